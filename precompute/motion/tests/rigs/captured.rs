//! Captured skeletons have the roles by shape that their profiles name. Skipped where the recordings are not at hand.

use crate::mocap::recording;
use throng_core::Joint;
use throng_motion::import::profile::load_profiles;
use throng_motion::import::{ImportConfig, expand, interpret, read_source};

#[test]
fn captured_skeletons_are_recognised_as_their_profiles_have_them() {
    let profiles = load_profiles(&[]).unwrap();
    let config = ImportConfig::default();
    for folder in
        ["cmu-asfamc/01", "cmu-asfamc/02", "cmu-asfamc/03", "snu/single", "snu/session23", "snu/multi", "bandai-1"]
    {
        let (mut clips, mut differ) = (0, Vec::new());
        for path in expand(&Vec::from_iter(recording(folder))).unwrap() {
            let source = read_source(&path, None).unwrap().swap_remove(0);
            let named = interpret(source.clone(), &config, &profiles).unwrap();
            let shaped = interpret(source, &config, &[]).unwrap();
            clips += 1;
            for role in Joint::ALL {
                let name = |i: &throng_motion::import::ImportedClip| {
                    i.roles.get(role).map_or("-".to_owned(), |j| i.clip.joints[j].name.clone())
                };
                if name(&named) != name(&shaped) {
                    differ.push(format!("{} {}: {} not {}", named.clip.name, role.name(), name(&shaped), name(&named)));
                }
            }
        }
        println!("{folder:<15} {clips:>3} clips, {} roles other than the profile's", differ.len());
        assert!(differ.is_empty(), "{}", differ.join("\n"));
    }
}
