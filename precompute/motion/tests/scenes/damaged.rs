//! Damaged scene files are refused with the file and what is wrong; none panics, and none asks for memory by a count.

use super::glb::{FLOAT, Glb, Style};
use super::{STYLE, only, parse, walk};
use serde_json::{Value, json};
use std::path::Path;
use throng_motion::import::gltf;

fn whole(style: Style) -> Glb {
    let mut glb = Glb::new();
    glb.add(&walk(), style);
    glb
}

fn refusal(bytes: &[u8]) -> String {
    let e = gltf::parse(bytes, Path::new("folder/a.glb")).expect_err("it is refused").to_string();
    assert!(e.starts_with("folder/a.glb: "), "{e}");
    e
}

#[test]
fn faults_name_the_file_and_the_part() {
    let good = whole(Style { skin: true, ..STYLE() });
    only(&good);
    type Fault = (fn(&mut Value), &'static str);
    let faults: [Fault; 34] = [
        (|j| j["animations"] = json!([]), "it holds no animation"),
        (|j| j["animations"][0]["channels"] = json!([]), "its animations move no skeleton"),
        (
            |j| j["animations"][0]["channels"][3]["target"]["node"] = json!(999),
            "animations[0].channels[3]: there is no node 999",
        ),
        (
            |j| j["animations"][0]["channels"][3]["sampler"] = json!(999),
            "animations[0].channels[3]: there is no sampler 999",
        ),
        (
            |j| j["animations"][0]["samplers"][2]["output"] = json!(999),
            "animations[0].samplers[2]: accessors[999]: there is no such",
        ),
        (|j| j["animations"][0]["samplers"][2]["output"] = json!(1), "expected VEC4, found SCALAR"),
        (|j| j["animations"][0]["samplers"][2]["interpolation"] = json!("WILD"), "unknown variant `WILD`"),
        (
            |j| j["animations"][0]["samplers"][2]["interpolation"] = json!("CUBICSPLINE"),
            "expected 180 values as VEC4 for 60 keys",
        ),
        (|j| j["accessors"][1]["count"] = json!(59), "expected 59 values"),
        (|j| j["accessors"][1]["count"] = json!(u64::MAX), "more numbers than its file can hold"),
        (|j| j["accessors"][1]["count"] = json!(61), "61 items reach beyond the 240 bytes of bufferViews[1]"),
        (|j| j["accessors"][1]["count"] = json!(-1), "expected a glTF 2.0 document"),
        (|j| j["accessors"][1]["count"] = json!(0), "expected times, found none"),
        (
            |j| j["accessors"][2]["componentType"] = json!(5124),
            "accessors[2]: expected numbers of 8 or 16 bits or of type 5126, found type 5124",
        ),
        (|j| j["accessors"][2]["type"] = json!("MAT2"), "expected VEC4, found MAT2"),
        (|j| j["accessors"][2]["bufferView"] = json!(999), "there is no bufferViews[999]"),
        (|j| j["accessors"][2]["byteOffset"] = json!(u64::MAX), "reach beyond"),
        (|j| j["bufferViews"][2]["byteLength"] = json!(u64::MAX), "bufferViews[2] reaches beyond"),
        (|j| j["bufferViews"][2]["byteStride"] = json!(3), "byteStride: expected at least 16, found 3"),
        (|j| j["bufferViews"][2]["buffer"] = json!(7), "no buffers[7]"),
        (|j| j["nodes"][4]["children"] = json!([999]), "nodes[4]: there is no node 999"),
        (|j| j["nodes"][4]["children"] = json!([4]), "nodes[4]: it is held more than once"),
        (|j| j["nodes"][4]["rotation"] = json!([0, 0, 0, 0]), "expected moderate numbers and a rotation"),
        (|j| j["nodes"][4]["translation"] = json!([1e30, 0, 0]), "expected moderate numbers and a rotation"),
        (|j| j["nodes"][4]["scale"] = json!([-1, 1, 1]), "is mirrored by a negative scale"),
        (|j| j["skins"][0]["joints"] = json!([0, 999]), "there is no node 999"),
        (|j| j["skins"][0]["joints"] = json!(vec![0; 5000]), "skins[0]: expected at most 4096 joints, found 5000"),
        (|j| j["skins"][0]["inverseBindMatrices"] = json!(1), "skins[0].inverseBindMatrices: "),
        (|j| j["buffers"][0]["uri"] = json!("../b.bin"), "buffers[0]: expected a file in its own folder"),
        (|j| j["buffers"][0]["uri"] = json!("data:,x"), "buffers[0]: expected data in base64"),
        (|j| j["buffers"] = json!([]), "no buffers[0]"),
        (|j| j["nodes"][4]["name"] = json!("n".repeat(1025)), "nodes[4]: expected a name of at most 1024 bytes"),
        (
            |j| j["animations"][0]["name"] = json!("n".repeat(1025)),
            "animation 0: expected a name of at most 1024 bytes",
        ),
        (
            |j| {
                let part = json!({ "bufferView": 2, "componentType": 5121 });
                j["accessors"][2]["sparse"] = json!({ "count": 61, "indices": part, "values": part });
            },
            "sparse: expected 60 items at most, found 61",
        ),
    ];
    for (spoil, expected) in faults {
        let mut bad = Glb { json: good.json.clone(), bytes: good.bytes.clone() };
        spoil(&mut bad.json);
        let e = refusal(&bad.glb());
        assert!(e.contains(expected), "expected {expected}: {e}");
    }
}

#[test]
fn times_are_in_order_and_moderate() {
    for (times, expected) in [
        ([0.0, 2.0, 1.0], "expected times in order, found 1 after 2"),
        ([0.0, f32::NAN, 1.0], "found NaN"),
        ([0.0, 1.0, 1e9], "expected seconds below 1000000"),
    ] {
        let mut glb = whole(STYLE());
        glb.json["animations"] = json!([]);
        glb.animation(STYLE(), &times, &[(0, "translation", vec![0.0; 9])]);
        let e = refusal(&glb.glb());
        assert!(e.contains("animations[0].samplers[0]: accessors[") && e.contains(expected), "{e}");
    }
}

#[test]
fn compressed_motion_is_refused_by_name_and_compressed_meshes_do_not_matter() {
    let mut glb = whole(STYLE());
    let other = glb.push("buffers", json!({ "byteLength": 999 }));
    let view = glb.push(
        "bufferViews",
        json!({ "buffer": other, "byteLength": 999, "extensions": { "EXT_meshopt_compression": { "buffer": 0 } } }),
    );
    glb.json["extensionsRequired"] = json!(["EXT_meshopt_compression", "KHR_draco_mesh_compression"]);
    only(&glb);
    let output = glb.json["animations"][0]["samplers"][0]["output"].as_u64().unwrap() as usize;
    glb.json["accessors"][output]["bufferView"] = json!(view);
    let e = refusal(&glb.glb());
    assert!(e.contains("is compressed (meshopt_compression); export without compression"), "{e}");
    glb.json["bufferViews"][view]["extensions"] = json!({});
    assert!(refusal(&glb.glb()).contains("has no bytes"));
}

#[test]
fn little_text_cannot_ask_for_much_memory_or_time() {
    // Keys of a second and of ten days: what lies between is made up to a length that no file pays for.
    let mut glb = whole(STYLE());
    glb.json["animations"] = json!([]);
    glb.animation(STYLE(), &[0.0, 0.03, 9e5], &[(0, "translation", vec![0.0; 9])]);
    assert!(refusal(&glb.glb()).contains("joints are too many for its file"));
    // What is above a skeleton is posed, too.
    let mut glb = whole(STYLE());
    glb.json["animations"] = json!([]);
    glb.animation(STYLE(), &[0.0, 300.0], &[(1, "translation", vec![0.0; 6])]);
    only(&glb);
    for i in 0..400 {
        glb.push(
            "nodes",
            json!({ "children": [if i == 0 { 0 } else { glb.json["nodes"].as_array().unwrap().len() - 1 }] }),
        );
    }
    assert!(refusal(&glb.glb()).contains("joints are too many for its file"));
    // Names of joints that every clip has.
    let mut glb = whole(STYLE());
    for _ in 0..100 {
        let end = glb.push("nodes", json!({}));
        glb.json["nodes"][0]["children"].as_array_mut().unwrap().push(json!(end));
    }
    glb.json["nodes"].as_array_mut().unwrap().iter_mut().for_each(|n| n["name"] = json!("n".repeat(1000)));
    let animation = json!({ "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
        "samplers": [glb.json["animations"][0]["samplers"][0]] });
    glb.json["animations"] = json!(vec![animation.clone(); 10]);
    assert_eq!(parse(&glb).len(), 10);
    glb.json["animations"] = json!(vec![animation; 3000]);
    assert!(refusal(&glb.glb()).contains("the joints of 3000 clips are too many for its file"));
    // Zeros that no bytes stand for.
    let mut glb = whole(STYLE());
    let sparse =
        json!({ "count": 0, "indices": { "bufferView": 0, "componentType": 5123 }, "values": { "bufferView": 0 } });
    let zeros = |count: u64| json!({ "componentType": FLOAT, "count": count, "type": "SCALAR", "sparse": sparse });
    let huge = glb.push("accessors", zeros(1 << 40));
    glb.json["animations"][0]["samplers"][0]["input"] = json!(huge);
    assert!(refusal(&glb.glb()).contains("more numbers than its file can hold"));
    // Many samplers whose keys are the same bytes.
    let mut glb = whole(STYLE());
    let times: Vec<f32> = (0..2000).map(|i| i as f32).collect();
    glb.json["animations"] = json!([]);
    glb.animation(STYLE(), &times, &[(0, "translation", vec![0.0; 6000])]);
    let animation = glb.json["animations"][0].clone();
    let output = animation["samplers"][0]["output"].clone();
    let accessor = glb.json["accessors"][animation["samplers"][0]["input"].as_u64().unwrap() as usize].clone();
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for i in 0..5000 {
        let input = glb.push("accessors", accessor.clone());
        samplers.push(json!({ "input": input, "output": output }));
        channels.push(json!({ "sampler": i, "target": { "node": 0, "path": "translation" } }));
    }
    glb.json["animations"] = json!([{ "channels": channels, "samplers": samplers }]);
    let e = refusal(&glb.glb());
    assert!(e.contains("more numbers than its file can hold"), "{e}");
    // Nodes below nodes.
    let mut deep = Glb::new();
    for i in 0..2000 {
        deep.push("nodes", json!({ "children": [i + 1] }));
    }
    deep.push("nodes", json!({}));
    deep.animation(STYLE(), &[0.0, 1.0], &[(0, "translation", vec![0.0; 6])]);
    assert!(refusal(&deep.glb()).contains("expected at most 512 levels of nodes"));
    let mut round = Glb::new();
    round.push("nodes", json!({ "children": [1] }));
    round.push("nodes", json!({ "children": [0] }));
    round.animation(STYLE(), &[0.0, 1.0], &[(0, "translation", vec![0.0; 6])]);
    assert!(refusal(&round.glb()).contains("2 nodes are below themselves"));
}

#[test]
fn shorter_files_are_refused_and_flipped_bits_do_no_harm() {
    let good = whole(Style { skin: true, sparse: true, ..STYLE() }).glb();
    for n in (0..good.len()).step_by(97) {
        refusal(&good[..n]);
    }
    let mut at = 17;
    for k in 0..1500 {
        at = (at * 7919 + k) % good.len();
        let mut bad = good.clone();
        bad[at] ^= 1 << (k % 8);
        for clip in gltf::parse(&bad, Path::new("a.glb")).unwrap_or_default() {
            assert!(clip.clip.translations.iter().all(|t| t.is_finite()), "byte {at}");
            assert!(clip.clip.rotations.iter().all(|r| r.is_finite()), "byte {at}");
        }
    }
}

#[cfg(feature = "fbx")]
#[test]
fn what_is_no_fbx_is_refused_by_name() {
    use throng_motion::import::fbx;
    let parse = |bytes: &[u8]| fbx::parse(bytes, Path::new("folder/a.fbx")).expect_err("it is refused").to_string();
    for bytes in [&b""[..], b"Kaydara FBX Binary  \0\x1a\0", b"no scene", b"o cube\nv 0 0 0\n", &[0xff; 4000]] {
        let e = parse(bytes);
        assert!(e.starts_with("folder/a.fbx: it is no FBX file that can be read: "), "{e}");
    }
    let empty = b"; FBX 7.4.0 project file\nFBXHeaderExtension: {\n FBXHeaderVersion: 1003\n FBXVersion: 7400\n}\nObjects: {\n}\n";
    assert!(parse(empty).contains("it holds no animation"), "{}", parse(empty));
}

#[cfg(not(feature = "fbx"))]
#[test]
fn fbx_is_refused_with_the_feature_that_it_needs() {
    let e = throng_motion::import::read_source(Path::new("a.fbx"), None).unwrap_err().to_string();
    assert!(e.contains("a.fbx: this program was built without FBX. Build it with `--features fbx`"), "{e}");
}
