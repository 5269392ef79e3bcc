//! The project's own scenes of crowds, which need no file.

use super::config::CrowdScene;
use crate::error::BuildError;
use std::path::Path;

/// Names and texts.
const TEXTS: [(&str, &str); 7] = [
    ("flock", include_str!("../../../../data/scenes/flock.toml")),
    ("corridor", include_str!("../../../../data/scenes/corridor.toml")),
    ("lanes", include_str!("../../../../data/scenes/lanes.toml")),
    ("circle", include_str!("../../../../data/scenes/circle.toml")),
    ("ring", include_str!("../../../../data/scenes/ring.toml")),
    ("bottleneck", include_str!("../../../../data/scenes/bottleneck.toml")),
    ("square", include_str!("../../../../data/scenes/square.toml")),
];

/// Names of the project's own scenes.
pub const OWN_SCENES: [&str; 7] = ["flock", "corridor", "lanes", "circle", "ring", "bottleneck", "square"];

/// One of the project's own scenes by its name; `None` for another name.
///
/// # Errors
/// As [`CrowdScene::load`].
pub fn own_scene(name: &str) -> Result<Option<CrowdScene>, BuildError> {
    let text = TEXTS.iter().find(|t| t.0 == name);
    text.map(|(name, text)| CrowdScene::from_text(text, Path::new(&format!("{name}.toml")))).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::crowd::{CrowdSpace, Layout};
    use glam::{Vec2, Vec3};

    #[test]
    fn every_own_scene_is_read_and_laid_out_and_resized() {
        for name in OWN_SCENES {
            let scene = own_scene(name).unwrap().expect("it is there");
            assert_eq!(scene.name, name);
            for members in [scene.num_members(), 100, 1000] {
                let scene = scene.resized(members);
                let laid_out = match scene.space {
                    CrowdSpace::Ground => Layout::<Vec2>::new(&scene).map(|l| l.num_members()),
                    CrowdSpace::Air => Layout::<Vec3>::new(&scene).map(|l| l.num_members()),
                };
                assert_eq!(laid_out.unwrap(), members, "{name}");
            }
        }
        assert!(own_scene("moon").unwrap().is_none());
    }
}
