// Throng for C#: one file for Unity's Assets, beside the native library (libthrong_c.so, throng_c.dll, libthrong_c.dylib).
// Compiled and run by Mono in the tests; not run in Unity yet.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Throng
{
    /// A call that failed; Message has the reason.
    public sealed class ThrongException : Exception
    {
        public readonly Status Status;
        public ThrongException(Status status, string why) : base(why) { Status = status; }
    }

    public enum Status
    {
        Ok, Pointer, Handle, Busy, Value, TooSmall, Io, Format, Gone, Full, Place, Unsupported, Panic
    }

    public enum Progress { Idle, Going, There, Blocked, NoPath }

    /// Axes and order of matrices: Unity's are columns of a left-handed Matrix4x4, X right, Y up, Z forward (m).
    public enum Layout { Throng, Unity, Unreal }

    /// Names a character; nobody else of its simulation ever has the same one.
    [StructLayout(LayoutKind.Sequential)]
    public struct Id { public uint Index, Generation; }

    /// Where somebody stands, in Throng's axes: X left, Z forward (m, rad).
    [StructLayout(LayoutKind.Sequential)]
    public struct Root { public Id Id; public uint IsThere; public float X, Z, Heading; }

    /// How characters move; Config.Standard has the defaults.
    [StructLayout(LayoutKind.Sequential)]
    public struct Config
    {
        UIntPtr structSize;
        public ulong Seed;
        public uint Capacity, Avoids;
        public float Temperature, HalfLifeSeconds;
        /// 1: steps also leave an Instance of everybody.
        public uint Instances;
        uint reserved;

        public static Config Standard
        {
            get { Config config; Native.Check(Native.throng_characters_config_init(out config, (UIntPtr)Marshal.SizeOf(typeof(Config)))); return config; }
        }
    }

    /// What a vertex shader needs to pose a character from Bundle.Rows (32 bytes), in Throng's axes: in Unity the place is
    /// (-X, Y, Z), and the turn about Y is -Heading.
    [StructLayout(LayoutKind.Sequential)]
    public struct Instance
    {
        public uint RowA, RowB;
        public ushort Frac, Blend;
        public uint Variant;
        public float X, Y, Z, Heading;
    }

    /// Who is posed: feet stay in place up to FullMetres from the eye, poses are computed up to PosedMetres.
    [StructLayout(LayoutKind.Sequential)]
    public struct Detail { public float EyeX, EyeZ, FullMetres, PosedMetres; }

    public enum Arm : uint { None, Point, Wave, CarryBeside, CarryBefore, CarryOnShoulder, Phone, Reach }

    /// What a body does beside its motion; see ThrongLayers in throng.h.
    [StructLayout(LayoutKind.Sequential)]
    public struct Layers
    {
        internal UIntPtr structSize;
        public uint Looks;
        public float LookX, LookY, LookZ;
        public Arm Left, Right;
        public float LeftX, LeftY, LeftZ, RightX, RightY, RightZ;
        public float LeanAhead, LeanLeft;
        public uint FirstFrame, NumFrames, Joints, Loops;
    }

    /// Tables of motion.
    public sealed class Bundle : IDisposable
    {
        internal ulong handle;

        public Bundle(string path) { Native.Check(Native.throng_bundle_open(Native.Text(path), out handle)); }
        /// From memory, as a TextAsset gives it; it is copied.
        public Bundle(byte[] bytes)
        {
            Native.Check(Native.throng_bundle_from_memory(bytes, (UIntPtr)bytes.Length, out handle));
        }
        public uint Policy(string behaviour)
        {
            uint number;
            Native.Check(Native.throng_bundle_policy(handle, Native.Text(behaviour), out number));
            return number;
        }
        /// Poses of all frame rows, as Simulation.Matrices has them: from each joint to the character's own frame.
        public float[] Rows(Layout layout = Layout.Unity)
        {
            UIntPtr count;
            Native.Check(Native.throng_bundle_num_rows(handle, out count));
            var rows = new float[(ulong)count * Simulation.NumJoints * (ulong)Native.throng_layout_floats(layout)];
            Native.Check(Native.throng_bundle_write_rows(handle, rows, (UIntPtr)(4 * (ulong)rows.LongLength), layout));
            return rows;
        }
        public void Dispose()
        {
            if (handle == 0) return;
            Native.throng_bundle_free(handle);
            handle = 0;
        }
    }

    /// Characters who move: those of a scene file, or of one bundle, who come, go and are told what to do.
    public sealed class Simulation : IDisposable
    {
        /// Matrices of a character.
        public const int NumJoints = 22;
        ulong handle;

        public Simulation(string scene) { Native.Check(Native.throng_simulation_open(Native.Text(scene), out handle)); }
        public Simulation(Bundle bundle, Config config)
        {
            Native.Check(Native.throng_characters_new(bundle.handle, ref config, out handle));
        }
        public Id Spawn(float x, float z, float heading)
        {
            Id id;
            Native.Check(Native.throng_characters_spawn(handle, x, z, heading, out id));
            return id;
        }
        public void Despawn(Id id) { Native.Check(Native.throng_characters_despawn(handle, id)); }
        public void Place(Id id, float x, float z, float heading)
        {
            Native.Check(Native.throng_characters_place(handle, id, x, z, heading));
        }
        public void Order(Id id, uint policy, float x, float y, float z)
        {
            Native.Check(Native.throng_characters_order(handle, id, policy, x, y, z));
        }
        public void SetLayers(Id id, Layers layers)
        {
            layers.structSize = (UIntPtr)Marshal.SizeOf(typeof(Layers));
            Native.Check(Native.throng_characters_set_layers(handle, id, ref layers));
        }
        public void Stop(Id id) { Native.Check(Native.throng_characters_stop(handle, id)); }
        public void TurnTo(Id id, float heading) { Native.Check(Native.throng_characters_turn_to(handle, id, heading)); }
        public void SetManner(Id id, string manner) { Native.Check(Native.throng_characters_set_manner(handle, id, Native.Text(manner))); }
        public Progress ProgressOf(Id id, out float leftMetres)
        {
            Progress progress;
            Native.Check(Native.throng_characters_progress(handle, id, out progress, out leftMetres));
            return progress;
        }
        public void Raise(string happening) { Native.Check(Native.throng_simulation_raise(handle, Native.Text(happening))); }
        public void Step(double seconds) { Native.Check(Native.throng_simulation_step(handle, seconds)); }

        public int Count
        {
            get { UIntPtr count; Native.Check(Native.throng_simulation_count(handle, out count)); return (int)count; }
        }
        public double Seconds
        {
            get { double time; Native.Check(Native.throng_simulation_time(handle, out time)); return time; }
        }
        public ulong Hash
        {
            get { ulong hash; Native.Check(Native.throng_simulation_hash(handle, out hash)); return hash; }
        }

        /// Where everybody stands; the array is used again where it has the length.
        public Root[] Roots(Root[] roots = null)
        {
            var count = Count;
            if (roots == null || roots.Length != count) roots = new Root[count];
            UIntPtr written;
            Native.Check(Native.throng_simulation_roots(handle, roots, (UIntPtr)count, out written));
            return roots;
        }

        /// The matrix from each joint to the world, of everybody: NumJoints times 16 floats a character (12 in Throng's
        /// layout). The array is used again where it has the length.
        public float[] Matrices(Layout layout = Layout.Unity, float[] matrices = null)
        {
            var each = NumJoints * (int)Native.throng_layout_floats(layout);
            var length = Count * each;
            if (matrices == null || matrices.Length != length) matrices = new float[length];
            var bytes = (UIntPtr)(4 * (ulong)length);
            Native.Check(Native.throng_simulation_write_matrices(handle, matrices, bytes, (UIntPtr)(4 * each), layout));
            return matrices;
        }

        /// Records of everybody, none unless Config.Instances; the array is used again where it has the length.
        public Instance[] Instances(Instance[] instances = null)
        {
            UIntPtr count;
            Native.Check(Native.throng_characters_instances(handle, null, UIntPtr.Zero, out count));
            if (instances == null || instances.Length != (int)count) instances = new Instance[(int)count];
            Native.Check(Native.throng_characters_instances(handle, instances, count, out count));
            return instances;
        }
        /// Who is posed from now on; null for everybody.
        public void SetDetail(Detail? detail)
        {
            Native.Check(Native.throng_characters_set_detail(handle, detail.HasValue ? new[] { detail.Value } : null));
        }

        public byte[] Save()
        {
            UIntPtr size;
            Native.Check(Native.throng_simulation_save(handle, null, UIntPtr.Zero, out size));
            var bytes = new byte[(int)size];
            Native.Check(Native.throng_simulation_save(handle, bytes, size, out size));
            return bytes;
        }
        public void Restore(byte[] saved)
        {
            Native.Check(Native.throng_simulation_restore(handle, saved, (UIntPtr)saved.Length));
        }
        public void Dispose()
        {
            if (handle == 0) return;
            Native.throng_simulation_free(handle);
            handle = 0;
        }
    }

    /// The calls of throng.h that the classes above make.
    static class Native
    {
        const string Library = "throng_c";

        /// Throws unless a call has succeeded.
        internal static void Check(Status status)
        {
            if (status == Status.Ok) return;
            var why = new byte[(int)throng_last_error(null, UIntPtr.Zero) + 1];
            throng_last_error(why, (UIntPtr)why.Length);
            throw new ThrongException(status, Encoding.UTF8.GetString(why, 0, why.Length - 1));
        }

        /// UTF-8 with a zero at its end.
        internal static byte[] Text(string text) { return Encoding.UTF8.GetBytes(text + "\0"); }

        [DllImport(Library)] static extern UIntPtr throng_last_error(byte[] buffer, UIntPtr size);
        [DllImport(Library)] internal static extern Status throng_bundle_open(byte[] path, out ulong bundle);
        [DllImport(Library)] internal static extern Status throng_bundle_from_memory(byte[] bytes, UIntPtr size, out ulong bundle);
        [DllImport(Library)] internal static extern Status throng_bundle_free(ulong bundle);
        [DllImport(Library)] internal static extern Status throng_bundle_policy(ulong bundle, byte[] behaviour, out uint policy);
        [DllImport(Library)] internal static extern Status throng_characters_config_init(out Config config, UIntPtr size);
        [DllImport(Library)] internal static extern Status throng_characters_new(ulong bundle, ref Config config, out ulong made);
        [DllImport(Library)] internal static extern Status throng_characters_spawn(ulong of, float x, float z, float heading, out Id id);
        [DllImport(Library)] internal static extern Status throng_characters_despawn(ulong of, Id id);
        [DllImport(Library)] internal static extern Status throng_characters_stop(ulong of, Id id);
        [DllImport(Library)] internal static extern Status throng_characters_turn_to(ulong of, Id id, float heading);
        [DllImport(Library)] internal static extern Status throng_characters_set_manner(ulong of, Id id, byte[] manner);
        [DllImport(Library)] internal static extern Status throng_characters_place(ulong of, Id id, float x, float z, float heading);
        [DllImport(Library)] internal static extern Status throng_characters_order(ulong of, Id id, uint policy, float x, float y, float z);
        [DllImport(Library)] internal static extern Status throng_characters_set_layers(ulong of, Id id, ref Layers layers);
        [DllImport(Library)] internal static extern Status throng_characters_progress(ulong of, Id id, out Progress now, out float left);
        [DllImport(Library)] internal static extern Status throng_simulation_open(byte[] path, out ulong made);
        [DllImport(Library)] internal static extern Status throng_simulation_free(ulong of);
        [DllImport(Library)] internal static extern Status throng_simulation_raise(ulong of, byte[] happening);
        [DllImport(Library)] internal static extern Status throng_simulation_step(ulong of, double seconds);
        [DllImport(Library)] internal static extern Status throng_simulation_count(ulong of, out UIntPtr count);
        [DllImport(Library)] internal static extern Status throng_simulation_time(ulong of, out double seconds);
        [DllImport(Library)] internal static extern Status throng_simulation_hash(ulong of, out ulong hash);
        [DllImport(Library)] internal static extern Status throng_simulation_roots(ulong of, [Out] Root[] roots, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] internal static extern Status throng_characters_instances(ulong of, [Out] Instance[] to, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] internal static extern Status throng_characters_set_detail(ulong of, Detail[] detail);
        [DllImport(Library)] internal static extern Status throng_bundle_num_rows(ulong of, out UIntPtr count);
        [DllImport(Library)] internal static extern Status throng_bundle_write_rows(ulong of, [Out] float[] to, UIntPtr bytes, Layout layout);
        [DllImport(Library)] internal static extern UIntPtr throng_layout_floats(Layout layout);
        [DllImport(Library)] internal static extern Status throng_simulation_write_matrices(ulong of, [Out] float[] to, UIntPtr bytes, UIntPtr stride, Layout layout);
        [DllImport(Library)] internal static extern Status throng_simulation_save(ulong of, [Out] byte[] to, UIntPtr capacity, out UIntPtr size);
        [DllImport(Library)] internal static extern Status throng_simulation_restore(ulong of, byte[] bytes, UIntPtr size);
    }
}
