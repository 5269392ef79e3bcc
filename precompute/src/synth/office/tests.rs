//! What the set promises, measured on the clips as everybody else sees them.

use super::*;

#[test]
fn dump() {
    let set = office(&SynthConfig::for_set(crate::synth::SynthSet::Office));
    let path = std::env::var("OFFICE_DUMP").unwrap();
    let clips: Vec<_> = set
        .clips
        .iter()
        .map(|c| {
            let pos: Vec<Vec<[f32; 3]>> = (0..c.num_frames())
                .map(|f| c.joint_positions(&set.skeleton, f).iter().map(|p| p.to_array()).collect())
                .collect();
            let tags: Vec<_> = c.tags.iter().map(|t| (t.name.clone(), t.range.start, t.range.end)).collect();
            let contacts: Vec<u8> = c.contacts.iter().map(|c| c.0).collect();
            serde_json::json!({"name": c.name, "pos": pos, "tags": tags, "contacts": contacts})
        })
        .collect();
    std::fs::write(path, serde_json::to_string(&clips).unwrap()).unwrap();
}
