//! Explanations of removed cells and links: computed on request, not stored.

use super::editor::Editor;
use crate::stitch::clearance::collision_span::nearest_sampled;
use crate::{stitch::connect::remains::JudgedGraph, stitch::report::RemovalReason};
use throng_core::Joint;

/// A part of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstanceItem {
    /// Cell number within the patch.
    Cell(u32),
    /// Link number within the patch.
    Link(u32),
}

/// Explanation why a cell or a link is removed.
#[derive(Clone, Debug, PartialEq)]
pub struct RemovalExplanation {
    /// Reason.
    pub reason: RemovalReason,
    /// Collision, if that is the reason.
    pub collision: Option<UnitCollision>,
    /// One sentence that names the units.
    pub message: String,
}

/// Collision of a body with a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitCollision {
    /// Number of the placed unit.
    pub unit: usize,
    /// Joint of the deepest sphere.
    pub joint: Joint,
    /// Depth (m).
    pub depth_m: f32,
    /// Frame of the link, counted from its first one.
    pub frame: u32,
}

impl Editor<'_> {
    /// Reason why a cell or a link of an instance is removed; `None` if it remains.
    ///
    /// (instance < number of instances, the item within its patch)
    pub fn reason(&self, instance: u32, item: InstanceItem) -> Option<RemovalReason> {
        let judged = JudgedGraph { joined: &self.made.joined, component: &self.made.component };
        match item {
            InstanceItem::Cell(c) => judged.cell_reason(instance, c),
            InstanceItem::Link(l) => judged.link_reason(instance, l),
        }
    }

    /// Explanation why a cell or a link of an instance is removed; `None` if it remains.
    ///
    /// (instance < number of instances, the item within its patch)
    pub fn explain_removal(&self, instance: u32, item: InstanceItem) -> Option<RemovalExplanation> {
        let reason = self.reason(instance, item)?;
        let what = match item {
            InstanceItem::Cell(c) => format!("cell {c}"),
            InstanceItem::Link(l) => format!("link {l}"),
        };
        let collision = match (reason, item) {
            (RemovalReason::Obstacle, InstanceItem::Link(l)) => self.collision(instance, l),
            _ => None,
        };
        let because = match (reason, &collision) {
            (RemovalReason::NoNeighbour, _) => "there is no tile across its edge".to_owned(),
            (RemovalReason::DeadEnd, _) => "from there no way leads on for ever".to_owned(),
            (RemovalReason::OutsideComponent, _) => "no way leads there from the rest of the world".to_owned(),
            (RemovalReason::Obstacle, None) => "a unit is in the way".to_owned(),
            (RemovalReason::Obstacle, Some(c)) => format!(
                "at its frame {} the {} is {:.2} m in {}",
                c.frame,
                c.joint.name(),
                c.depth_m,
                self.stitcher.placer.library.describe(self.environment(), c.unit)
            ),
        };
        Some(RemovalExplanation {
            reason,
            collision,
            message: format!("{what} of {}: {because}", self.describe(instance)),
        })
    }

    /// Description of an instance: its patch and its units.
    fn describe(&self, instance: u32) -> String {
        let (f, library) = (&self.made.patches.fitted[instance as usize], &self.stitcher.placer.library);
        let units: Vec<String> = f.units.iter().map(|&u| library.describe(self.environment(), u as usize)).collect();
        format!("patch {} on {}", library.names[f.patch as usize].name, units.join(" and "))
    }

    /// Deepest collision of a link with any unit that obstructs it.
    fn collision(&self, instance: u32, link: u32) -> Option<UnitCollision> {
        let s = &self.stitcher;
        let patch = self.made.patches.fitted[instance as usize].patch;
        let roots = s.paths(patch).roots_of_link(link as usize);
        let first_row = s.placer.patches.links_of(patch as usize)[link as usize].frame as usize;
        let first = self.made.patches.obstacles.partition_point(|o| o.0 < instance);
        let mut deepest: Option<UnitCollision> = None;
        for (_, unit, relation) in self.made.patches.obstacles[first..].iter().take_while(|o| o.0 == instance) {
            let (field, to_unit) = (s.field(relation.b), relation.placement().inverse());
            for k in nearest_sampled(roots.len()) {
                let root = to_unit.compose(roots[k]);
                let Some((joint, depth_m)) = s.bodies().deepest(first_row + k, root, field) else { continue };
                if deepest.as_ref().is_none_or(|d| depth_m > d.depth_m) {
                    deepest = Some(UnitCollision { unit: *unit as usize, joint, depth_m, frame: k as u32 });
                }
            }
        }
        deepest
    }
}
