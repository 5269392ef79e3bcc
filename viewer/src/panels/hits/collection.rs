//! The effective hits of a bundle, and which of them are selected.

use super::HitsInput;
use crate::bundle::OpenBundle;
use crate::panels::paint::{RowClick, RowTable, TableCell, TableColumn, TableResponse, TableSort};
use crate::panels::{clip_frame, moment};
use eframe::egui::Ui;
use glam::Vec3;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use throng_core::Joint;

/// Order of two hits by each column of the list.
const ORDERS: [fn(&HitEntry, &HitEntry) -> Ordering; 7] = [
    |a, b| a.row.cmp(&b.row),
    |a, b| a.kind.cmp(&b.kind),
    |a, b| a.joint.cmp(&b.joint),
    |a, b| a.force.total_cmp(&b.force),
    |a, b| a.angle().total_cmp(&b.angle()),
    |a, b| a.distance().total_cmp(&b.distance()),
    |a, b| a.position.y.total_cmp(&b.position.y),
];

/// An effective hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitEntry {
    /// Frame row of the hit.
    pub row: u32,
    /// Clip of the hit.
    pub clip: usize,
    /// Frame of the hit within the clip.
    pub frame: u32,
    /// Number of its kind.
    pub kind: u32,
    /// Joint that strikes.
    pub joint: Joint,
    /// Speed relative to the fastest hit of its kind.
    pub force: f32,
    /// (m/s)
    pub speed_mps: f32,
    /// Position relative to the planar root: left, up, ahead (m).
    pub position: Vec3,
    /// Direction of the blow. Unit.
    pub direction: Vec3,
}

impl HitEntry {
    /// Angle from straight ahead to the left (rad).
    pub fn angle(&self) -> f32 {
        self.position.x.atan2(self.position.z)
    }

    /// Distance over ground (m).
    pub fn distance(&self) -> f32 {
        self.position.x.hypot(self.position.z)
    }
}

/// Which hits are selected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HitFilter {
    /// Only of this kind.
    pub kind: Option<u32>,
    /// Only with this joint.
    pub joint: Option<Joint>,
}

/// Least and greatest angle, distance and height, as the paper reports them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitRanges {
    /// (rad)
    pub angle: [f32; 2],
    /// (m)
    pub distance: [f32; 2],
    /// (m)
    pub height: [f32; 2],
    /// Share of the fastest hit's speed.
    pub force: [f32; 2],
}

/// All hits of a bundle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitCollection {
    /// In the order of the bundle.
    pub entries: Vec<HitEntry>,
    /// Names of the kinds, by number.
    pub kinds: Vec<String>,
}

impl HitCollection {
    /// Collects them.
    pub fn from_bundle(bundle: &OpenBundle) -> Self {
        let tables = bundle.tables();
        let entry = |h: &throng_core::HitRecord| {
            let (clip, frame) = clip_frame(bundle, h.frame);
            HitEntry {
                row: h.frame,
                clip,
                frame,
                kind: h.kind,
                joint: Joint::ALL[h.joint as usize],
                force: h.force,
                speed_mps: h.speed_mps,
                position: h.position(),
                direction: h.direction(),
            }
        };
        let kinds = tables.meta().hit_kinds().map(str::to_owned).collect();
        Self { entries: tables.hits().iter().map(entry).collect(), kinds }
    }

    /// Name of a kind.
    pub fn kind(&self, kind: u32) -> &str {
        self.kinds.get(kind as usize).map_or("hit", String::as_str)
    }

    /// Joints that strike.
    pub fn joints_present(&self) -> BTreeSet<Joint> {
        self.entries.iter().map(|e| e.joint).collect()
    }

    /// Numbers of the selected hits, in the order asked for.
    pub fn select(&self, filter: HitFilter, sort: TableSort) -> Vec<usize> {
        let HitFilter { kind, joint } = filter;
        let admits = |e: &HitEntry| kind.is_none_or(|k| k == e.kind) && joint.is_none_or(|j| j == e.joint);
        let mut out: Vec<usize> = (0..self.entries.len()).filter(|&i| admits(&self.entries[i])).collect();
        sort.sort(&mut out, &ORDERS, &self.entries);
        out
    }

    /// Ranges over some of the hits; none if there are none.
    pub fn ranges(&self, of: &[usize]) -> Option<HitRanges> {
        let bounds = |value: fn(&HitEntry) -> f32| {
            let grow = |[low, high]: [f32; 2], v: f32| [low.min(v), high.max(v)];
            of.iter().map(|&i| value(&self.entries[i])).fold([f32::INFINITY, f32::NEG_INFINITY], grow)
        };
        (!of.is_empty()).then(|| HitRanges {
            angle: bounds(HitEntry::angle),
            distance: bounds(HitEntry::distance),
            height: bounds(|e| e.position.y),
            force: bounds(|e| e.force),
        })
    }
}

/// A joint's name for people, such as `left hand`.
pub fn joint_name(joint: Joint) -> String {
    joint.name().replace('_', " ")
}

const COLUMNS: [TableColumn<'static>; 7] = [
    TableColumn::text("moment", "Clip and time", 110.0, 1.0),
    TableColumn::text("kind", "Kind of blow, or name of the tag", 48.0, 0.0).spare(2),
    TableColumn::text("limb", "What strikes", 76.0, 0.0),
    TableColumn::number("force", "Speed over that of the fastest hit of its kind", 50.0),
    TableColumn::number("angle", "From straight ahead to the left [rad]", 48.0).spare(1),
    TableColumn::number("dist.", "Distance over ground [m]", 44.0),
    TableColumn::number("height", "Above the ground [m]", 50.0),
];

/// Shows the selected hits.
///
/// - `scrolls`: brings the hit that stands out into sight.
pub fn show_list(ui: &mut Ui, input: &HitsInput<'_>, sort: &mut TableSort, scrolls: bool) -> TableResponse {
    let &HitsInput { bundle, hits, shown, .. } = input;
    let table = RowTable {
        click: RowClick::Does("Show"),
        sort: Some(*sort),
        selected: input.standing_out.and_then(|s| shown.iter().position(|&i| i == s)),
        scroll_to_selected: scrolls,
        ..RowTable::new("hits", &COLUMNS, shown.len())
    };
    let response = table.show(ui, |row, column| cell(bundle, hits, &hits.entries[shown[row]], column));
    *sort = response.sort.unwrap_or(*sort);
    response
}

/// A hit in a column, which [`COLUMNS`] numbers.
fn cell(bundle: &OpenBundle, hits: &HitCollection, e: &HitEntry, column: usize) -> TableCell {
    match column {
        0 => TableCell::new(moment(bundle, e.row)).ending(),
        1 => TableCell::new(hits.kind(e.kind)),
        2 => TableCell::new(joint_name(e.joint)),
        3 => TableCell::new(format!("{:.2}", e.force)).bar(e.force),
        4 => TableCell::new(format!("{:.2}", e.angle())),
        5 => TableCell::new(format!("{:.2}", e.distance())),
        _ => TableCell::new(format!("{:.2}", e.position.y)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(row: u32, kind: u32, joint: Joint, position: Vec3) -> HitEntry {
        let direction = Vec3::Z;
        HitEntry {
            row,
            clip: 0,
            frame: row,
            kind,
            joint,
            force: 1.0 / (1.0 + row as f32),
            speed_mps: 5.0,
            position,
            direction,
        }
    }

    fn collection() -> HitCollection {
        HitCollection {
            entries: vec![
                entry(3, 0, Joint::LeftHand, Vec3::new(0.3, 1.5, 0.4)),
                entry(5, 0, Joint::RightHand, Vec3::new(0.0, 1.2, 1.0)),
                entry(9, 1, Joint::RightFoot, Vec3::new(-0.2, 0.8, 0.2)),
            ],
            kinds: vec!["punch".into(), "kick".into()],
        }
    }

    #[test]
    fn only_hits_of_the_chosen_kind_and_limb_are_shown() {
        let c = collection();
        let found = |kind, joint| c.select(HitFilter { kind, joint }, TableSort::default());
        assert_eq!(found(None, None), [0, 1, 2]);
        assert_eq!(found(Some(0), None), [0, 1]);
        assert_eq!(found(None, Some(Joint::RightHand)), [1]);
        assert_eq!(found(Some(1), Some(Joint::RightHand)), [0usize; 0]);
        assert_eq!((c.kind(1), c.kind(7)), ("kick", "hit"));
    }

    #[test]
    fn the_order_is_that_of_the_column() {
        let c = collection();
        let by = |column, descending| c.select(HitFilter::default(), TableSort { column, descending });
        let [force, distance, height] = [3, 5, 6];
        assert_eq!(by(distance, false), [2, 0, 1]);
        assert_eq!(by(force, true), [0, 1, 2]);
        assert_eq!(by(height, true), [0, 1, 2]);
    }

    #[test]
    fn ranges_are_those_of_the_selected_hits() {
        let c = collection();
        let r = c.ranges(&[0, 1]).unwrap();
        assert!((r.angle[0] - 0.0).abs() < 1e-6 && (r.angle[1] - 0.3f32.atan2(0.4)).abs() < 1e-6, "{r:?}");
        assert!((r.distance[0] - 0.5).abs() < 1e-6 && r.distance[1] == 1.0);
        assert_eq!(r.height, [1.2, 1.5]);
        assert_eq!(c.ranges(&[]), None);
    }
}
