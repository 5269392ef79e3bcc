//! Explanations of removed cells and links: computed on request, not stored.

use super::editor::Editor;
use crate::stitch::clearance::hit::looked_at;
use crate::stitch::connect::remains::Judged;
use crate::stitch::report::Reason;
use throng_core::Joint;

/// A part of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// Cell number within the patch.
    Cell(u32),
    /// Link number within the patch.
    Link(u32),
}

/// Explanation why a cell or a link is removed.
#[derive(Clone, Debug, PartialEq)]
pub struct Why {
    /// Reason.
    pub reason: Reason,
    /// Collision, if that is the reason.
    pub collision: Option<Collision>,
    /// One sentence that names the units.
    pub message: String,
}

/// Collision of a body with a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
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
    pub fn reason(&self, instance: u32, item: Item) -> Option<Reason> {
        let judged = Judged { joined: &self.made().joined, settled: &self.made().settled };
        match item {
            Item::Cell(c) => judged.cell(instance, c),
            Item::Link(l) => judged.link(instance, l),
        }
    }

    /// Explanation why a cell or a link of an instance is removed; `None` if it remains.
    ///
    /// (instance < number of instances, the item within its patch)
    pub fn why(&self, instance: u32, item: Item) -> Option<Why> {
        let reason = self.reason(instance, item)?;
        let what = match item {
            Item::Cell(c) => format!("cell {c}"),
            Item::Link(l) => format!("link {l}"),
        };
        let collision = match (reason, item) {
            (Reason::Obstacle, Item::Link(l)) => self.collision(instance, l),
            _ => None,
        };
        let because = match (reason, &collision) {
            (Reason::NoNeighbour, _) => "there is no tile across its edge".to_owned(),
            (Reason::DeadEnd, _) => "from there no way leads on for ever".to_owned(),
            (Reason::OutsideComponent, _) => "no way leads there from the rest of the world".to_owned(),
            (Reason::Obstacle, None) => "a unit is in the way".to_owned(),
            (Reason::Obstacle, Some(c)) => format!(
                "at its frame {} the {} is {:.2} m in {}",
                c.frame,
                c.joint.name(),
                c.depth_m,
                self.stitcher().placer.library.describe(self.environment(), c.unit)
            ),
        };
        Some(Why { reason, collision, message: format!("{what} of {}: {because}", self.describe(instance)) })
    }

    /// Description of an instance: its patch and its units.
    fn describe(&self, instance: u32) -> String {
        let (f, library) = (&self.made().laid.fitted[instance as usize], &self.stitcher().placer.library);
        let units: Vec<String> = f.units.iter().map(|&u| library.describe(self.environment(), u as usize)).collect();
        format!("patch {} on {}", library.names[f.patch as usize].name, units.join(" and "))
    }

    /// Deepest collision of a link with any unit that obstructs it.
    fn collision(&self, instance: u32, link: u32) -> Option<Collision> {
        let s = self.stitcher();
        let patch = self.made().laid.fitted[instance as usize].patch;
        let roots = s.paths(patch).of(link as usize);
        let first_row = s.placer.patches.links_of(patch as usize)[link as usize].frame as usize;
        let first = self.made().laid.obstacles.partition_point(|o| o.0 < instance);
        let mut deepest: Option<Collision> = None;
        for (_, unit, relation) in self.made().laid.obstacles[first..].iter().take_while(|o| o.0 == instance) {
            let (field, to_unit) = (s.field(relation.b), relation.placement().inverse());
            for k in looked_at(roots.len()) {
                let root = to_unit.compose(roots[k]);
                let Some((joint, depth_m)) = s.bodies().deepest(first_row + k, root, field) else { continue };
                if deepest.as_ref().is_none_or(|d| depth_m > d.depth_m) {
                    deepest = Some(Collision { unit: *unit as usize, joint, depth_m, frame: k as u32 });
                }
            }
        }
        deepest
    }
}
