//! Which hits of a bundle are selected, their ranges, and their list.

use super::HitsInput;
use crate::panels::paint::{RowClick, RowTable, TableCell, TableColumn, TableResponse, TableSort};
use eframe::egui::Ui;
use std::cmp::Ordering;
use throng_core::Joint;
use throng_precompute::annotate::hits::HitPoint;

/// Order of two hits by each column of the list.
const ORDERS: [fn(&HitPoint, &HitPoint) -> Ordering; 7] = [
    |a, b| (&a.clip, a.frame).cmp(&(&b.clip, b.frame)),
    |a, b| a.kind.cmp(&b.kind),
    |a, b| a.joint.cmp(&b.joint),
    |a, b| a.force.total_cmp(&b.force),
    |a, b| a.angle().total_cmp(&b.angle()),
    |a, b| a.distance().total_cmp(&b.distance()),
    |a, b| a.position.y.total_cmp(&b.position.y),
];

/// Which hits are selected.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitFilter {
    /// Only of this kind.
    pub kind: Option<String>,
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

/// Numbers of the selected hits, in the order asked for.
pub fn select_hits(hits: &[HitPoint], HitFilter { kind, joint }: &HitFilter, sort: TableSort) -> Vec<usize> {
    let admits = |h: &HitPoint| kind.as_ref().is_none_or(|k| *k == h.kind) && joint.is_none_or(|j| j == h.joint);
    let mut out: Vec<usize> = (0..hits.len()).filter(|&i| admits(&hits[i])).collect();
    sort.sort(&mut out, &ORDERS, hits);
    out
}

impl HitRanges {
    /// Ranges over some of the hits; none if there are none.
    pub fn over(hits: &[HitPoint], some: &[usize]) -> Option<Self> {
        let bounds = |value: fn(&HitPoint) -> f32| {
            let grow = |[low, high]: [f32; 2], v: f32| [low.min(v), high.max(v)];
            some.iter().map(|&i| value(&hits[i])).fold([f32::INFINITY, f32::NEG_INFINITY], grow)
        };
        (!some.is_empty()).then(|| Self {
            angle: bounds(HitPoint::angle),
            distance: bounds(HitPoint::distance),
            height: bounds(|h| h.position.y),
            force: bounds(|h| h.force),
        })
    }
}

/// A joint's name for people, such as `left hand`.
pub fn joint_name(joint: Joint) -> String {
    joint.name().replace('_', " ")
}

/// Clip and time of a hit.
pub fn moment(hit: &HitPoint) -> String {
    format!("{} {:.2} s", hit.clip, hit.time_s)
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
    let &HitsInput { hits, shown, .. } = input;
    let table = RowTable {
        click: RowClick::Does("Show"),
        sort: Some(*sort),
        selected: input.standing_out.and_then(|s| shown.iter().position(|&i| i == s)),
        scroll_to_selected: scrolls,
        ..RowTable::new("hits", &COLUMNS, shown.len())
    };
    let response = table.show(ui, |row, column| cell(&hits[shown[row]], column));
    *sort = response.sort.unwrap_or(*sort);
    response
}

/// A hit in a column, which [`COLUMNS`] numbers.
fn cell(e: &HitPoint, column: usize) -> TableCell {
    match column {
        0 => TableCell::new(moment(e)).ending(),
        1 => TableCell::new(&e.kind),
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
    use glam::Vec3;

    fn hit(frame: usize, kind: &str, joint: Joint, position: Vec3) -> HitPoint {
        HitPoint {
            clip: "a".into(),
            frame,
            time_s: 0.0,
            kind: kind.into(),
            joint,
            position,
            direction: Vec3::Z,
            speed_mps: 5.0,
            force: 1.0 / (1.0 + frame as f32),
        }
    }

    fn hits() -> [HitPoint; 3] {
        [
            hit(3, "punch", Joint::LeftHand, Vec3::new(0.3, 1.5, 0.4)),
            hit(5, "punch", Joint::RightHand, Vec3::new(0.0, 1.2, 1.0)),
            hit(9, "kick", Joint::RightFoot, Vec3::new(-0.2, 0.8, 0.2)),
        ]
    }

    #[test]
    fn only_hits_of_the_chosen_kind_and_limb_are_shown() {
        let hits = hits();
        let found = |kind: Option<&str>, joint| {
            select_hits(&hits, &HitFilter { kind: kind.map(str::to_owned), joint }, TableSort::default())
        };
        assert_eq!(found(None, None), [0, 1, 2]);
        assert_eq!(found(Some("punch"), None), [0, 1]);
        assert_eq!(found(None, Some(Joint::RightHand)), [1]);
        assert_eq!(found(Some("kick"), Some(Joint::RightHand)), [0usize; 0]);
    }

    #[test]
    fn the_order_is_that_of_the_column() {
        let hits = hits();
        let by = |column, descending| select_hits(&hits, &HitFilter::default(), TableSort { column, descending });
        let [force, distance, height] = [3, 5, 6];
        assert_eq!(by(distance, false), [2, 0, 1]);
        assert_eq!(by(force, true), [0, 1, 2]);
        assert_eq!(by(height, true), [0, 1, 2]);
    }

    #[test]
    fn ranges_are_those_of_the_selected_hits() {
        let hits = hits();
        let r = HitRanges::over(&hits, &[0, 1]).unwrap();
        assert!((r.angle[0] - 0.0).abs() < 1e-6 && (r.angle[1] - 0.3f32.atan2(0.4)).abs() < 1e-6, "{r:?}");
        assert!((r.distance[0] - 0.5).abs() < 1e-6 && r.distance[1] == 1.0);
        assert_eq!(r.height, [1.2, 1.5]);
        assert_eq!(HitRanges::over(&hits, &[]), None);
    }
}
