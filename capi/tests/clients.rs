//! Programs in C11 and C++17, built by the compiler that is there and run under AddressSanitizer, and one in C#, run by Mono,
//! see what Rust sees.

use glam::Vec3;
use std::path::{Path, PathBuf};
use std::process::Command;
use throng_runtime::characters::{AvoidConfig, CharactersConfig, MotionSet, PolicyCharacters, SampleJob, Spawn};
use throng_runtime::simulation::{Scene, Simulation};
use throng_runtime::{Bundle, CharacterGroup, Inline, Mat3x4, NUM_JOINTS, Planar};

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn bundle() -> PathBuf {
    let golden = folder().join("../data/golden");
    golden.join(format!("tables_v{}.throng", throng_runtime::format::VERSION))
}

/// Where cargo puts the library, beside this test.
fn library() -> PathBuf {
    let test = std::env::current_exe().expect("a path");
    let beside = test.parent().expect("a folder");
    let name = "libthrong_c.so";
    let found = [beside.join(name), beside.with_file_name(name)].into_iter().find(|p| p.exists());
    found.unwrap_or_else(|| panic!("no {name} in {} or above", beside.display()))
}

/// Builds and runs a client; nothing where there is no compiler of its language.
fn run(source: &str, compiler: &str, options: &[&str], arguments: &[&Path]) -> Option<String> {
    let out = tempfile::tempdir().expect("a folder");
    let program = out.path().join("client");
    let library = library();
    // A copy, as a package would install it; so that the sanitizer finds it, too.
    std::fs::copy(&library, out.path().join("libthrong_c.so")).expect("copied");
    let build = |sanitizer: &[&str]| {
        let mut command = Command::new(compiler);
        command.args(options).args(["-g", "-O1", "-Wall", "-Wextra", "-Werror", "-pthread"]).args(sanitizer);
        command.arg("-I").arg(folder().join("include")).arg(folder().join("tests/clients").join(source));
        command.arg("-L").arg(out.path()).args(["-lthrong_c", "-lm", "-o"]).arg(&program);
        command.output()
    };
    let built = match build(&["-fsanitize=address,undefined"]) {
        Err(e) => {
            println!("skipped: {compiler} cannot be started ({e})");
            return None;
        }
        Ok(built) if String::from_utf8_lossy(&built.stderr).contains("cannot find") => {
            println!("without AddressSanitizer: its library is not there");
            build(&[]).expect("started before")
        }
        Ok(built) => built,
    };
    assert!(built.status.success(), "{source}: {}", String::from_utf8_lossy(&built.stderr));
    let ran = Command::new(&program).args(arguments).env("LD_LIBRARY_PATH", out.path()).output().expect("started");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(ran.status.success(), "{source}: {:?}\n{}\n{}", ran.status, text(&ran.stdout), text(&ran.stderr));
    Some(text(&ran.stdout))
}

/// The walk of the clients.
fn walk() -> PolicyCharacters {
    let bundle = Bundle::open(bundle()).expect("the golden bundle");
    let config =
        CharactersConfig { avoid: Some(AvoidConfig::default()), instances: true, ..CharactersConfig::default() };
    let mut people = PolicyCharacters::with_capacity(&bundle, 40, config).expect("room");
    let approach = bundle.policy("approach").expect("a policy");
    for k in 0..40 {
        let root = Planar::new(3.0 * (k % 8) as f32, 3.0 * (k / 8) as f32, 0.1 * k as f32);
        let id = people.spawn(Spawn::standing_at(root)).expect("room");
        people.order(id, approach.order_towards(Vec3::new(10.0, 0.0, 8.0))).expect("an order");
    }
    (0..90).for_each(|_| people.step(1.0 / 60.0, &Inline).expect("a step"));
    people
}

fn fnv(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

fn of_floats(floats: impl IntoIterator<Item = f32>) -> u64 {
    fnv(floats.into_iter().flat_map(f32::to_le_bytes))
}

#[test]
fn c_sees_what_rust_sees_and_misuse_is_refused() {
    let Some(found) = run("client.c", "cc", &["-std=c11"], &[&bundle()]) else { return };
    let people = walk();
    let bodies = people.bodies();
    let roots = bodies.roots.iter().map(|r| format!(" {:016x}", of_floats([r.x, r.z, r.heading])));
    let mut world = vec![[Mat3x4::default(); 22]; bodies.ids.len()];
    bodies.write_world(&mut world).expect("as many as there are");
    let all = |floats: &dyn Fn(&Mat3x4) -> Vec<f32>| {
        let each = world.iter().map(|pose| of_floats(pose.iter().flat_map(floats)));
        each.fold(0_u64, |all, one| all.wrapping_mul(31).wrapping_add(one))
    };
    // Each axis by hand: Unity's X is our -X; Unreal's X, Y and Z are our Z, -X and Y in centimetres.
    let unity = |m: &Mat3x4| {
        let [x, y, z] = m.rows;
        let column = |c: usize, s: f32| [-s * x[c], s * y[c], s * z[c], 0.0];
        let mut floats = [column(0, -1.0), column(1, 1.0), column(2, 1.0)].concat();
        floats.extend([-x[3], y[3], z[3], 1.0]);
        floats
    };
    let unreal = |m: &Mat3x4| {
        let [x, y, z] = m.rows;
        let column = |c: usize, s: f32| [s * z[c], -s * x[c], s * y[c], 0.0];
        let mut floats = [column(2, 1.0), column(0, -1.0), column(1, 1.0)].concat();
        floats.extend([z[3] * 100.0, -x[3] * 100.0, y[3] * 100.0, 1.0]);
        floats
    };
    let ours = |m: &Mat3x4| m.rows.as_flattened().to_vec();
    let bundle = Bundle::open(bundle()).expect("the golden bundle");
    let (motion_set, frames) = (&MotionSet::new(&bundle), (0..bundle.frames().len() as u32).collect::<Vec<_>>());
    let mut rows = vec![Mat3x4::default(); frames.len() * NUM_JOINTS];
    let job = SampleJob { motion_set, frames: &frames, ratios: &vec![0.0; frames.len()], matrices: &mut rows };
    job.run().expect("frames that there are");
    let rows = |floats: &dyn Fn(&Mat3x4) -> Vec<f32>| of_floats(rows.iter().flat_map(floats));
    let expected = format!(
        "rows {:016x}\nrows {:016x}\nrows {:016x}\nhash {:016x}\nroots{}\ninstances {:016x}\nmatrices {:016x}\nmatrices {:016x}\nmatrices {:016x}\n",
        rows(&ours),
        rows(&unity),
        rows(&unreal),
        people.hash(),
        roots.collect::<String>(),
        fnv(bytemuck::cast_slice(people.instances()).iter().copied()),
        all(&ours),
        all(&unity),
        all(&unreal)
    );
    assert_eq!(found, expected);
}

#[test]
fn c_sharp_sees_what_rust_sees() {
    let out = tempfile::tempdir().expect("a folder");
    std::fs::copy(library(), out.path().join("libthrong_c.so")).expect("copied");
    let program = out.path().join("client.exe");
    let mut compiler = Command::new("mcs");
    compiler.arg("-warnaserror").arg(format!("-out:{}", program.display()));
    compiler.args(["unity/Throng.cs", "tests/clients/Client.cs"].map(|file| folder().join(file)));
    let Ok(built) = compiler.output() else { return println!("skipped: there is no mcs (Mono)") };
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(built.status.success(), "{}{}", text(&built.stdout), text(&built.stderr));
    let mut mono = Command::new("mono");
    let ran = mono.arg(&program).arg(bundle()).env("LD_LIBRARY_PATH", out.path()).output().expect("mono beside mcs");
    assert!(ran.status.success(), "{:?}\n{}\n{}", ran.status, text(&ran.stdout), text(&ran.stderr));
    assert_eq!(text(&ran.stdout), format!("hash {:016x}\nGone: True\n", walk().hash()));
}

#[test]
fn cpp_sees_what_rust_sees() {
    let scene = tempfile::tempdir().expect("a folder");
    let path = scene.path().join("people.toml");
    let bundle_path = bundle().canonicalize().expect("it is there");
    let text = format!(
        "bundle = {bundle_path:?}\n\n[[groups]]\nmotion = \"policy\"\ncount = 12\nbehaviours = [{{ name = \"approach\" }}]\n\n[[groups]]\nmotion = \"none\"\ncount = 30\n\
         place = {{ block = {{ from = [-30.0, -5.0], to = [-20.0, 5.0] }} }}\n\
         goal = {{ area = {{ from = [20.0, -5.0], to = [30.0, 5.0] }} }}\n"
    );
    std::fs::write(&path, text).expect("written");
    let mut rust = Simulation::new(&Scene::load(&path).and_then(|s| s.open()).expect("a scene")).expect("people");
    (0..60).for_each(|_| rust.step(1.0 / 30.0).expect("a step"));
    let Some(found) = run("client.cpp", "c++", &["-std=c++17"], &[&bundle(), &path]) else { return };
    assert_eq!(found, format!("hash {:016x}\nscene {:016x}\n", walk().hash(), rust.hash()));
}
