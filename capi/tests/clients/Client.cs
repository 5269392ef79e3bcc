// Walks characters of a bundle as the other clients do, and prints what the test compares with Rust.
using System;
using System.IO;
using Throng;

static class Client
{
    static int Main(string[] arguments)
    {
        using (var bundle = new Bundle(File.ReadAllBytes(arguments[0])))
        {
            var config = Config.Standard;
            config.Capacity = 40;
            config.Instances = 1;
            using (var people = new Simulation(bundle, config))
            {
                var approach = bundle.Policy("approach");
                var ids = new Id[40];
                for (var k = 0; k < 40; ++k)
                {
                    ids[k] = people.Spawn(3f * (k % 8), 3f * (k / 8), 0.1f * k);
                    people.Order(ids[k], approach, 10f, 0f, 8f);
                }
                for (var step = 0; step < 45; ++step) people.Step(1.0 / 60.0);
                var saved = people.Save();
                for (var step = 0; step < 10; ++step) people.Step(1.0 / 60.0);
                people.Restore(saved);
                for (var step = 0; step < 45; ++step) people.Step(1.0 / 60.0);
                Console.WriteLine("hash {0:x16}", people.Hash);
                var roots = people.Roots();
                float left;
                if (roots.Length != 40 || roots[7].IsThere != 1 || people.ProgressOf(ids[7], out left) != Progress.Going) return 1;
                // Unity's X is -X, and so the hips stand there.
                var hips = people.Matrices()[16 * Simulation.NumJoints * 7 + 12];
                if (Math.Abs(hips + roots[7].X) > 0.3f) return 2;
                var instances = people.Instances();
                if (instances.Length != 40 || instances[7].X != roots[7].X || instances[7].Variant != ids[7].Index) return 4;
                if (bundle.Rows().Length <= instances[7].RowA * Simulation.NumJoints * 16) return 5;
                people.SetDetail(new Detail { FullMetres = -1f, PosedMetres = -1f });
                people.Step(1.0 / 60.0);
                people.SetDetail(null);
                people.Despawn(ids[7]);
                try
                {
                    people.Place(ids[7], 0f, 0f, 0f);
                    return 3;
                }
                catch (ThrongException told)
                {
                    Console.WriteLine("{0}: {1}", told.Status, told.Message.Length > 0);
                }
            }
        }
        return 0;
    }
}
