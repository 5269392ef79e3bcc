//! Scene files of a clip: glTF and FBX as text, with as little as these formats allow.

#[cfg(feature = "fbx")]
use glam::{EulerRot, Vec3};
#[cfg(feature = "fbx")]
use std::fmt::Write as _;
use throng_motion::raw::RawClip;

/// Joints that turn, with the numbers of all frames.
struct Tracks<'a> {
    clip: &'a RawClip,
    joints: Vec<usize>,
}

impl<'a> Tracks<'a> {
    fn new(clip: &'a RawClip) -> Self {
        Self { clip, joints: (0..clip.joints.len()).filter(|&j| !clip.joints[j].is_end).collect() }
    }

    /// A value of a joint for each frame.
    fn frames<T>(&self, values: &[T], joint: usize) -> impl Iterator<Item = T>
    where
        T: Copy,
    {
        let all: Vec<T> = values.iter().skip(joint).step_by(self.clip.joints.len()).copied().collect();
        all.into_iter()
    }
}

/// A clip in centimetres as a glTF document with its numbers in the text.
pub fn gltf(clip: &RawClip) -> String {
    let tracks = Tracks::new(clip);
    let (mut bytes, mut accessors) = (Vec::<u8>::new(), Vec::new());
    let mut accessor = |kind: &str, count: usize, numbers: Vec<f32>| {
        let text = format!(
            "{{\"bufferView\":0,\"byteOffset\":{},\"componentType\":5126,\"count\":{count},\"type\":\"{kind}\"}}",
            bytes.len()
        );
        bytes.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
        accessors.push(text);
        accessors.len() - 1
    };
    let n = clip.num_frames;
    let times = accessor("SCALAR", n, (0..n).map(|f| (f as f64 / clip.rate_hz) as f32).collect());
    let (mut nodes, mut channels, mut samplers) = (Vec::new(), Vec::new(), Vec::new());
    for &j in &tracks.joints {
        let of = |c: &usize| clip.joints[*c].parent == Some(j);
        let children: Vec<String> =
            tracks.joints.iter().filter(|c| of(c)).map(|&c| place(&tracks, c).to_string()).collect();
        let children =
            if children.is_empty() { String::new() } else { format!(",\"children\":[{}]", children.join(",")) };
        let (name, at) = (&clip.joints[j].name, clip.joints[j].offset * 0.01);
        nodes.push(format!("{{\"name\":\"{name}\",\"translation\":[{},{},{}]{children}}}", at.x, at.y, at.z));
        let turns = tracks.frames(&clip.rotations, j).flat_map(|r| r.to_array()).collect();
        let ways = tracks.frames(&clip.translations, j).flat_map(|t| (t * 0.01).to_array()).collect();
        for (path, kind, numbers) in [("rotation", "VEC4", turns), ("translation", "VEC3", ways)] {
            let output = accessor(kind, n, numbers);
            let node = place(&tracks, j);
            channels
                .push(format!("{{\"sampler\":{},\"target\":{{\"node\":{node},\"path\":\"{path}\"}}}}", samplers.len()));
            samplers.push(format!("{{\"input\":{times},\"output\":{output}}}"));
        }
    }
    let list = |parts: &[String]| parts.join(",\n");
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\n\"nodes\":[{}],\n\"animations\":[{{\"name\":\"walk\",\n\"channels\":[{}],\n\
         \"samplers\":[{}]}}],\n\"accessors\":[{}],\n\"bufferViews\":[{{\"buffer\":0,\"byteLength\":{}}}],\n\
         \"buffers\":[{{\"uri\":\"data:application/octet-stream;base64,{}\"}}]}}\n",
        list(&nodes),
        list(&channels),
        list(&samplers),
        list(&accessors),
        bytes.len(),
        base64(&bytes)
    )
}

/// Where a joint is in the list of those that turn.
fn place(tracks: &Tracks<'_>, joint: usize) -> usize {
    tracks.joints.iter().position(|&j| j == joint).unwrap_or(0)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for c in bytes.chunks(3) {
        let v = c.iter().fold(0u32, |v, &b| v << 8 | u32::from(b)) << (8 * (3 - c.len()));
        (0..=c.len()).for_each(|i| out.push(DIGITS[(v >> (18 - 6 * i) & 63) as usize] as char));
    }
    out
}

/// Units of time of FBX in a second.
#[cfg(feature = "fbx")]
const TICKS: f64 = 46_186_158_000.0;

/// A clip in centimetres at 30 Hz as FBX 7.4.
#[cfg(feature = "fbx")]
pub fn fbx(clip: &RawClip) -> String {
    let tracks = Tracks::new(clip);
    let tick = |frame: usize| (frame as f64 / clip.rate_hz * TICKS).round() as i64;
    let last = tick(clip.num_frames.saturating_sub(1));
    let (mut objects, mut links) = (String::new(), String::new());
    let _ = write!(
        objects,
        "  AnimationStack: 1, \"AnimStack::walk\", \"\" {{\n    Properties70: {{\n      \
         P: \"LocalStop\", \"KTime\", \"Time\", \"\",{last}\n    }}\n  }}\n  AnimationLayer: 2, \"AnimLayer::base\", \"\" {{\n  }}\n"
    );
    links.push_str("  C: \"OO\",2,1\n");
    for &j in &tracks.joints {
        let (id, name, at) = (1000 + j, &clip.joints[j].name, clip.joints[j].offset);
        let _ = write!(
            objects,
            "  Model: {id}, \"Model::{name}\", \"LimbNode\" {{\n    Version: 232\n    Properties70: {{\n      \
             P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",{},{},{}\n    }}\n  }}\n",
            at.x, at.y, at.z
        );
        let _ = writeln!(links, "  C: \"OO\",{id},{}", clip.joints[j].parent.map_or(0, |p| 1000 + p));
        let degrees = |r: glam::Quat| {
            let (z, y, x) = r.to_euler(EulerRot::ZYX);
            Vec3::new(x, y, z) * 1f32.to_degrees()
        };
        let turns: Vec<Vec3> = tracks.frames(&clip.rotations, j).map(degrees).collect();
        let ways: Vec<Vec3> = tracks.frames(&clip.translations, j).collect();
        for (k, (letter, property, values)) in
            [("R", "Lcl Rotation", turns), ("T", "Lcl Translation", ways)].into_iter().enumerate()
        {
            let node = 10_000 + 10 * j + 5 * k;
            let _ = writeln!(objects, "  AnimationCurveNode: {node}, \"AnimCurveNode::{letter}\", \"\" {{\n  }}");
            let _ = write!(links, "  C: \"OO\",{node},2\n  C: \"OP\",{node},{id}, \"{property}\"\n");
            for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
                let curve = node + 1 + axis;
                let list = |of: &dyn Fn(usize) -> String| (0..clip.num_frames).map(of).collect::<Vec<_>>().join(",");
                let (times, numbers) = (list(&|f| tick(f).to_string()), list(&|f| values[f][axis].to_string()));
                let n = clip.num_frames;
                let _ = write!(
                    objects,
                    "  AnimationCurve: {curve}, \"AnimCurve::\", \"\" {{\n    KeyVer: 4008\n    KeyTime: *{n} {{\n      a: \
                     {times}\n    }}\n    KeyValueFloat: *{n} {{\n      a: {numbers}\n    }}\n    KeyAttrFlags: *1 {{\n      \
                     a: 24836\n    }}\n    KeyAttrDataFloat: *4 {{\n      a: 0,0,0,0\n    }}\n    KeyAttrRefCount: *1 {{\n      \
                     a: {n}\n    }}\n  }}\n"
                );
                let _ = writeln!(links, "  C: \"OP\",{curve},{node}, \"d|{letter}\"");
            }
        }
    }
    format!(
        "; FBX 7.4.0 project file\nFBXHeaderExtension: {{\n  FBXHeaderVersion: 1003\n  FBXVersion: 7400\n}}\n\
         GlobalSettings: {{\n  Version: 1000\n  Properties70: {{\n    P: \"UpAxis\", \"int\", \"Integer\", \"\",1\n    \
         P: \"UpAxisSign\", \"int\", \"Integer\", \"\",1\n    P: \"FrontAxis\", \"int\", \"Integer\", \"\",2\n    \
         P: \"FrontAxisSign\", \"int\", \"Integer\", \"\",1\n    P: \"CoordAxis\", \"int\", \"Integer\", \"\",0\n    \
         P: \"CoordAxisSign\", \"int\", \"Integer\", \"\",1\n    P: \"UnitScaleFactor\", \"double\", \"Number\", \"\",1\n    \
         P: \"TimeMode\", \"enum\", \"\", \"\",6\n  }}\n}}\nObjects: {{\n{objects}}}\nConnections: {{\n{links}}}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::super::seeds;
    use std::path::Path;
    use throng_motion::import::{SourceClip, bvh, gltf as reader};

    /// The joints are where they are in the clip of which the file was made.
    fn check(mut found: Vec<SourceClip>) {
        let truth = bvh::parse(&seeds::bvh()[0], Path::new("a.bvh")).unwrap().clip;
        assert_eq!(found.len(), 1);
        let found = found.swap_remove(0).clip;
        assert_eq!((found.rate_hz, found.num_frames), (truth.rate_hz, truth.num_frames));
        let place = |name: &str| truth.joints.iter().position(|j| j.name == name).unwrap();
        assert_eq!(found.joints.len(), truth.joints.iter().filter(|j| !j.is_end).count());
        for f in 0..truth.num_frames {
            let (found_at, want) = (found.world(f), truth.world(f));
            for (joint, (at, _)) in found.joints.iter().zip(found_at) {
                let want = want[place(&joint.name)].0 * 0.01;
                assert!(at.distance(want) < 1e-5, "{} of frame {f} is at {at}, not {want}", joint.name);
            }
        }
    }

    #[test]
    fn scene_files_hold_the_clip_that_they_were_made_of() {
        check(reader::parse(&seeds::gltf_motion()[0], Path::new("a.gltf")).unwrap());
        #[cfg(feature = "fbx")]
        check(throng_motion::import::fbx::parse(&seeds::fbx()[0], Path::new("a.fbx")).unwrap());
    }

    /// A transform takes as long as there are layers to add up, so each of them counts, moving or not.
    #[cfg(feature = "fbx")]
    #[test]
    fn layers_of_fbx_count_as_what_they_take() {
        let text = String::from_utf8(seeds::fbx().swap_remove(0)).unwrap();
        // The stack says how long it is where it has both of these.
        let time = |name: &str, ticks: i64| format!("P: \"{name}\", \"KTime\", \"Time\", \"\",{ticks}\n      ");
        let times = time("LocalStart", 0) + &time("LocalStop", 100 * super::TICKS as i64);
        let long = text.replacen("P: \"LocalStop\"", &(times + "P: \"Other\""), 1);
        let with = |more: usize| {
            let ids = || 100_000..100_000 + more;
            let layers: String =
                ids().map(|id| format!("  AnimationLayer: {id}, \"AnimLayer::\", \"\" {{\n  }}\n")).collect();
            let links: String = ids().map(|id| format!("  C: \"OO\",{id},1\n")).collect();
            let text = long.replace("Objects: {\n", &format!("Objects: {{\n{layers}"));
            let text = text.replace("Connections: {\n", &format!("Connections: {{\n{links}"));
            throng_motion::import::fbx::parse(text.as_bytes(), Path::new("a.fbx"))
        };
        let clip = |more: usize| with(more).unwrap().swap_remove(0).clip;
        let alone = clip(0);
        assert_eq!(alone.num_frames, 3001);
        // As many as are taken at most: 2^21 transforms, and one for each byte.
        let most = (1..).take_while(|n| 3001 * alone.joints.len() * n <= 2 << 20).last().unwrap();
        let layered = clip(most - 1);
        let apart = layered.rotations.iter().zip(&alone.rotations).map(|(a, b)| a.dot(*b).abs());
        assert!(apart.fold(1.0, f32::min) > 1.0 - 1e-6, "layers without curves move nothing");
        let e = with(2 * most).map(|_| ()).unwrap_err().to_string();
        assert!(
            e.starts_with("a.fbx: animation `walk`: 3001 frames of ") && e.contains("are too many for its file"),
            "{e}"
        );
    }
}
