//! Which units a pose belongs to (Lee, Choi and Lee 2006, section 4).

use super::PlacedGeometry;
use super::touch::{GeometryTouchConfig, PARTS, SkinPoint, SkinPoints};
use glam::{Quat, Vec3};
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};

/// Finds the placed units that poses belong to.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitMembership {
    probes: SkinPoints,
    touch: GeometryTouchConfig,
}

impl UnitMembership {
    /// For a skeleton's proportions.
    pub fn new(skeleton: &Skeleton, touch: &GeometryTouchConfig) -> Self {
        Self { probes: SkinPoints::new(skeleton), touch: touch.clone() }
    }

    /// The placed units that a pose belongs to, ascending: a planted part touches the unit's geometry, or the hips are
    /// in its region.
    ///
    /// - `transforms`: position and rotation of all joints, in the frame of the environment.
    ///
    /// # Source
    /// Lee, Choi and Lee (2006), section 4. Differs: the hips, not the whole body, intersect the box, so that a pose belongs to few units.
    pub fn units_of(
        &self,
        transforms: &[(Vec3, Quat); NUM_JOINTS],
        contacts: Contacts,
        environment: &PlacedGeometry,
    ) -> Vec<usize> {
        let hips = transforms[Joint::Hips.index()].0;
        let touches = |part: usize, u: usize| {
            let [_, off] = self.probes.limits(part, &self.touch);
            let near = |p: &SkinPoint| environment.nearest_of_unit(u, p.position(transforms), off + p.radius).is_some();
            self.probes.points_of(part).iter().any(near)
        };
        let planted: Vec<usize> = (0..PARTS.len()).filter(|&part| contacts.any(PARTS[part])).collect();
        let is_in = |&u: &usize| {
            let at = environment.placement(u).inverse_transform_point(hips);
            environment.geometry(u).region.contains(at) || planted.iter().any(|&part| touches(part, u))
        };
        (0..environment.units.len()).filter(is_in).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::placed::tests::placed;
    use super::*;
    use throng_motion::clip::joint_transforms;

    #[test]
    fn poses_belong_to_what_they_touch_and_to_the_regions_their_hips_are_in() {
        let units = "[[units]]\nname = \"panel\"\nshapes = [{ box = { at = [0.0, -0.05, 0.0], size = [2.0, 0.1, 2.0] } \
                     }]\n[[units]]\nname = \"step\"\nshapes = [{ box = { at = [0.0, 0.1, 0.0], size = [1.0, 0.2, 0.4] \
                     } }]\nregion = { min = [-0.5, 5.0, -0.2], max = [0.5, 6.0, 0.2] }\n";
        let e = placed(
            units,
            "{ unit = \"panel\", at = [0.0, 0.0, 0.0] }, { unit = \"panel\", at = [0.0, 0.0, 2.0] }, \
             { unit = \"step\", at = [0.0, 0.0, 0.3] }",
        );
        let s = Skeleton::default();
        let belonging = UnitMembership::new(&s, &GeometryTouchConfig::default());
        let of = |at: Vec3, contacts: u8| {
            let t = joint_transforms(&s, s.offsets[0] + at, |_| Quat::IDENTITY);
            belonging.units_of(&t, Contacts(contacts), &e)
        };
        // Toes over the edge between panels: hips in the first one, toes on the second.
        assert_eq!(of(Vec3::Z * 0.9, 15), [0, 1]);
        assert_eq!(of(Vec3::Z * 0.9, 5), [0], "the toes are not planted");
        assert_eq!(of(Vec3::new(0.0, 0.2, 0.3), 15), [0, 2], "feet on the step, hips above the panel");
        assert_eq!(of(Vec3::new(0.0, 0.2, 0.3), 0), [0]);
        assert_eq!(of(Vec3::new(0.0, 4.4, 0.3), 0), [2]);
        assert!(of(Vec3::X * 4.0, 15).is_empty());
    }
}
