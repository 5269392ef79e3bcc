use super::super::geometry::with_triangles;
use super::*;
use crate::environment::UnitSet;
use crate::patch::PatchConfig;
use glam::Vec3;

/// A square in the plane y = 0 as two triangles, moved by a node within a node.
fn square(buffer: &str, indices: &str) -> String {
    format!(
        r#"{{"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"children":[1],"translation":[0,1,0]}},{{"mesh":0,"rotation":[0,0.70710678,0,0.70710678],"scale":[2,1,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}},{{"mode":1,"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},{indices}],
        "bufferViews":[{{"buffer":0,"byteLength":64,"byteStride":16}},{{"buffer":0,"byteOffset":64,"byteLength":12}}],
        "buffers":[{buffer}]}}"#
    )
}

const INDICES: &str = r#"{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}"#;

/// Positions with four bytes between them, then six indices of two bytes.
fn bytes() -> Vec<u8> {
    let mut out = Vec::new();
    for p in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]] {
        p.iter().for_each(|v| out.extend(v.to_le_bytes()));
        out.extend([0xee; 4]);
    }
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|i| out.extend(i.to_le_bytes()));
    out
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let json = format!("{json}{}", " ".repeat(json.len().next_multiple_of(4) - json.len()));
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    out.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(0x4E4F_534Au32, json.as_bytes()), (0x004E_4942, binary)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(chunk);
    }
    out
}

fn check(triangles: &[[Vec3; 3]]) {
    // Twice as long along x, then turned so that x becomes -z, then a metre up.
    let want = [
        [Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 1.0, -2.0), Vec3::new(1.0, 1.0, -2.0)],
        [Vec3::new(0.0, 1.0, 0.0), Vec3::new(1.0, 1.0, -2.0), Vec3::new(1.0, 1.0, 0.0)],
    ];
    assert_eq!(triangles.len(), 2);
    for (a, b) in triangles.iter().flatten().zip(want.iter().flatten()) {
        assert!(a.distance(*b) < 1e-5, "{a} is not {b}");
    }
}

fn encoded(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for c in bytes.chunks(3) {
        let v = c.iter().fold(0u32, |v, &b| v << 8 | u32::from(b)) << (8 * (3 - c.len()));
        (0..=c.len()).for_each(|i| out.push(DIGITS[(v >> (18 - 6 * i) & 63) as usize] as char));
        out.push_str(&"=".repeat(3 - c.len()));
    }
    out
}

#[test]
fn binary_external_and_embedded_buffers_give_the_same_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("a.glb"), glb(&square("{\"byteLength\":76}", INDICES), &bytes())).unwrap();
    check(&read(&path("a.glb")).unwrap());
    std::fs::write(path("some part.bin"), bytes()).unwrap();
    std::fs::write(path("b.gltf"), square("{\"byteLength\":76,\"uri\":\"some%20part.bin\"}", INDICES)).unwrap();
    check(&read(&path("b.gltf")).unwrap());
    let uri = format!("{{\"uri\":\"data:application/octet-stream;base64,{}\"}}", encoded(&bytes()));
    std::fs::write(path("c.gltf"), square(&uri, INDICES)).unwrap();
    check(&read(&path("c.gltf")).unwrap());
}

#[test]
fn faults_name_the_file_and_the_part() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let fault = |content: &[u8]| {
        std::fs::write(&path, content).unwrap();
        let e = read(&path).unwrap_err().to_string();
        assert!(e.contains(&folder.path().display().to_string()), "{e}");
        e
    };
    let buffer = "{\"byteLength\":76}";
    let index = |a: &str| fault(&glb(&square(buffer, a), &bytes()));
    let e = index(r#"{"bufferView":1,"componentType":5126,"count":6,"type":"SCALAR"}"#);
    assert!(e.contains("primitives[0]: accessors[1]: expected indices as SCALAR of whole numbers"), "{e}");
    let e = index(r#"{"bufferView":1,"componentType":5123,"count":7,"type":"SCALAR"}"#);
    assert!(e.contains("7 items reach beyond the 12 bytes of bufferViews[1]"), "{e}");
    let e = index(r#"{"bufferView":0,"byteOffset":2,"componentType":5123,"count":3,"type":"SCALAR"}"#);
    assert!(e.contains("of 4 positions: expected less"), "{e}");
    let e = index(r#"{"bufferView":9,"componentType":5123,"count":6,"type":"SCALAR"}"#);
    assert!(e.contains("there is no bufferViews[9]"), "{e}");
    assert!(fault(&glb(&square(buffer, INDICES), &bytes()[..60])).contains("reaches beyond the 60 bytes"));
    assert!(fault(b"glTF\x01\0\0\0").contains("expected glTF version 2, found 1"));
    assert!(fault(b"{]").contains("expected a glTF 2.0 document as JSON"));
    assert!(fault(b"{}").contains("expected triangles"));
    let cycle = br#"{"scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}]}"#;
    assert!(fault(cycle).contains("nodes[0]: it is held more than once"));
    let chain: Vec<String> = (1..100).map(|i| format!(r#"{{"children":[{i}]}}"#)).collect();
    let deep = format!(r#"{{"scenes":[{{"nodes":[0]}}],"nodes":[{},{{}}]}}"#, chain.join(","));
    assert!(fault(deep.as_bytes()).contains("expected at most 64 levels"));
    let draco = br#"{"extensionsRequired":["KHR_draco_mesh_compression"]}"#;
    assert!(fault(draco).contains("`KHR_draco_mesh_compression` is not supported"));
    let missing = square("{\"uri\":\"nowhere.bin\"}", INDICES);
    assert!(fault(missing.as_bytes()).contains("nowhere.bin"));
}

#[test]
fn every_shorter_file_is_refused_without_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let whole = glb(&square("{\"byteLength\":76}", INDICES), &bytes());
    for n in 0..whole.len() {
        std::fs::write(&path, &whole[..n]).unwrap();
        assert!(read(&path).is_err(), "{n} bytes of {}", whole.len());
    }
}

/// `nodes` nodes that show one mesh of `parts` parts, all of which share `positions` positions and `indices` indices.
fn shared(nodes: usize, parts: usize, [positions, indices]: [usize; 2]) -> Vec<u8> {
    let list = |item: &str, n: usize| vec![item; n].join(",");
    let part = r#"{"attributes":{"POSITION":0,"NORMAL":7},"indices":1}"#;
    let json = format!(
        r#"{{"nodes":[{}],"meshes":[{{"primitives":[{}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{positions},"type":"VEC3"}},
        {{"bufferView":1,"componentType":5121,"count":{indices},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":768}},{{"buffer":0,"byteOffset":768,"byteLength":600}}],
        "buffers":[{{}}]}}"#,
        list(r#"{"mesh":0}"#, nodes),
        list(part, parts)
    );
    // All positions are 0, all indices too.
    glb(&json, &[0; 768 + 600])
}

#[test]
fn little_text_cannot_ask_for_much_memory_or_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let read = |file: Vec<u8>| {
        assert!(file.len() < 203_000, "{} bytes", file.len());
        std::fs::write(&path, file).unwrap();
        read(&path).map(|t| t.len()).map_err(|e| e.to_string())
    };
    assert_eq!(read(shared(30, 40, [64, 600])), Ok(240_000));
    // 1.8e9 triangles; then few triangles of many positions; then nothing at all, very often.
    for counts in [[1, 600], [64, 3], [64, 0]] {
        let e = read(shared(9000, 1000, counts)).unwrap_err();
        assert!(e.contains("a file may have 5000000 triangles and 15000000 positions at most"), "{e}");
    }
    let e = read(shared(9000, 1000, [0, 0])).unwrap_err();
    assert!(e.contains("nodes may show 1000000 parts of meshes at most"), "{e}");
    let nodes = format!("{{\"nodes\":[{}]}}", vec!["{}"; 1_000_001].join(","));
    std::fs::write(&path, nodes).unwrap();
    let e = super::read(&path).unwrap_err().to_string();
    assert!(e.contains("a list may have 1000000 entries, found more"), "{e}");
}

#[test]
fn buffers_lie_in_the_folder_of_the_mesh() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("mesh");
    std::fs::create_dir_all(folder.join("deep")).unwrap();
    let path = folder.join("a.gltf");
    std::fs::write(outer.path().join("b.bin"), bytes()).unwrap();
    std::fs::write(folder.join("deep/b.bin"), bytes()).unwrap();
    let with = |uri: &str| {
        std::fs::write(&path, square(&format!("{{\"uri\":\"{uri}\"}}"), INDICES)).unwrap();
        read(&path).map_err(|e| e.to_string())
    };
    check(&with("deep/b.bin").unwrap());
    check(&with("./deep/b.bin").unwrap());
    assert_eq!(buffer_files(&path).unwrap(), [folder.join("./deep/b.bin")]);
    let absolute = folder.join("deep/b.bin").display().to_string().replace('\\', "/");
    for uri in
        ["../b.bin", "deep/../../b.bin", "%2e%2e/b.bin", "/dev/zero", "/etc/passwd", "file:///b.bin", "", &absolute]
    {
        let e = with(uri).unwrap_err();
        assert!(
            e.contains(&format!("a.gltf: buffers[0]: expected a file in its own folder or below, found `{uri}`")),
            "{e}"
        );
    }
    assert!(with("deep").unwrap_err().contains("is a folder"));
    #[cfg(unix)]
    {
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, folder.join(name)).unwrap();
        link("../b.bin", "out.bin");
        link("/dev/zero", "zero.bin");
        link("deep/b.bin", "in.bin");
        check(&with("in.bin").unwrap());
        for uri in ["out.bin", "zero.bin"] {
            assert!(with(uri).unwrap_err().contains("expected a file in its own folder"), "{uri}");
        }
    }
}

#[test]
fn a_mesh_that_is_no_file_is_refused_at_once() {
    #[cfg(unix)]
    assert!(read(Path::new("/dev/zero")).unwrap_err().to_string().contains("is a device or a pipe, expected a mesh"));
    let folder = tempfile::tempdir().unwrap();
    assert!(read(folder.path()).unwrap_err().to_string().contains("is a folder, expected a mesh"));
}

#[test]
fn what_is_wrong_with_a_mesh_is_told_with_the_line_of_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.glb"), "no mesh").unwrap();
    let path = folder.path().join("units.toml");
    let text = "[[units]]\nname = \"floor\"\n\n[[units]]\nname = \"statue\"\n[[units.shapes]]\n\
                box = { at = [0, 0, 0], size = [1, 1, 1] }\n[[units.shapes]]\nmesh = { file = \"bad.glb\" }\n";
    std::fs::write(&path, text).unwrap();
    let units = UnitSet::load(&path).unwrap();
    let patches = PatchConfig { units: Some(path.clone()), ..PatchConfig::default() };
    let e = crate::patch::scenes(&[], &patches, &units).unwrap_err().to_string();
    assert!(e.contains("units.toml:9:10: units[1].shapes[1].mesh.file: ") && e.contains("bad.glb: expected"), "{e}");
}

#[test]
fn the_triangles_of_all_units_are_counted_together() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.glb"), glb(&square("{\"byteLength\":76}", INDICES), &bytes())).unwrap();
    let unit = |name: &str| format!("[[units]]\nname = \"{name}\"\nshapes = [{{ mesh = {{ file = \"a.glb\" }} }}]\n");
    let text = [unit("one"), unit("two"), unit("three")].concat();
    let units = UnitSet::parse(&text, &folder.path().join("units.toml")).unwrap();
    // Two each: no mesh is too large, all of them are.
    assert_eq!(with_triangles(&units, 6).unwrap().len(), 3);
    let e = with_triangles(&units, 5).unwrap_err().to_string();
    assert!(e.starts_with("units[2].shapes: the meshes of all units may have 5 triangles at most, found more"), "{e}");
}
