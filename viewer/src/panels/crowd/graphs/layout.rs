//! Layout of the states of a small graph: in rows, by number of edges from the start.

use eframe::egui::{Rect, Vec2, pos2, vec2};
use throng_simulation::scene::StateGraphConfig;

/// Space between rows, and between the boxes of a row (points).
const ROWS: f32 = 40.0;
const COLUMNS: f32 = 18.0;
/// Space at each side, where edges pass and turn back (points).
const MARGIN: f32 = 26.0;

/// A graph of states, by number.
#[derive(Clone, Debug, PartialEq)]
pub struct StateGraphShape {
    /// Number of the state in which it begins.
    pub start: usize,
    /// From which state, any where absent, to which (number of edges).
    pub edges: Vec<(Option<usize>, usize)>,
}

impl StateGraphShape {
    /// The graph of a scene; states are in the order of their names.
    pub fn from_config(graph: &StateGraphConfig) -> Self {
        let number = |name: &str| graph.states.keys().position(|s| s == name).unwrap_or(0);
        let edges = graph.edges.iter().map(|e| (e.from.as_deref().map(number), number(&e.to)));
        Self { start: number(&graph.start), edges: edges.collect() }
    }

    /// States by their number of edges from the start; edges from any state count from the start.
    fn rows(&self, num: usize) -> Vec<Vec<usize>> {
        let mut far = vec![usize::MAX; num];
        let mut rows = vec![vec![self.start]];
        far[self.start] = 0;
        while let Some(last) = rows.last() {
            let mut next = Vec::new();
            for &state in last {
                for &(from, to) in &self.edges {
                    if from.is_none_or(|f| f == state) && far[to] == usize::MAX {
                        far[to] = rows.len();
                        next.push(to);
                    }
                }
            }
            if next.is_empty() {
                break;
            }
            rows.push(next);
        }
        rows
    }
}

/// Lays out boxes of some sizes within a width, which is kept to unless a single box is wider; returns them and the height.
pub fn lay_out(shape: &StateGraphShape, sizes: &[Vec2], width: f32) -> (Vec<Rect>, f32) {
    let room = width - 2.0 * MARGIN;
    let mut boxes = vec![Rect::ZERO; sizes.len()];
    let mut y = 2.0;
    for row in shape.rows(sizes.len()) {
        for part in wrapped(&row, sizes, room) {
            let taken: f32 = part.iter().map(|&s| sizes[s].x).sum::<f32>() + COLUMNS * (part.len() - 1) as f32;
            let height = part.iter().map(|&s| sizes[s].y).fold(0.0, f32::max);
            // Spare width goes between the boxes, too, so that edges have room.
            let spare = ((room - taken) / (part.len() + 1) as f32).max(0.0);
            let mut x = MARGIN + spare;
            for state in part {
                boxes[state] = Rect::from_min_size(pos2(x, y), vec2(sizes[state].x, height));
                x += sizes[state].x + COLUMNS + spare;
            }
            y += height + ROWS;
        }
    }
    (boxes, (y - ROWS + 4.0).max(0.0))
}

/// Splits a row into as many parts as the width needs.
fn wrapped(row: &[usize], sizes: &[Vec2], room: f32) -> Vec<Vec<usize>> {
    let mut parts: Vec<Vec<usize>> = Vec::new();
    let mut taken = 0.0;
    for &state in row {
        let more = sizes[state].x + COLUMNS;
        match parts.last_mut() {
            Some(part) if taken + more <= room + COLUMNS => part.push(state),
            _ => {
                parts.push(vec![state]);
                taken = 0.0;
            }
        }
        taken += more;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_lie_in_rows_by_their_distance_from_the_start_and_do_not_overlap() {
        let edges = vec![(Some(0), 1), (Some(0), 2), (Some(1), 3), (None, 4), (Some(3), 0), (Some(2), 2)];
        let shape = StateGraphShape { start: 0, edges };
        let sizes = [vec2(60.0, 20.0), vec2(90.0, 20.0), vec2(90.0, 20.0), vec2(40.0, 20.0), vec2(90.0, 20.0)];
        let (boxes, height) = lay_out(&shape, &sizes, 330.0);
        for (i, a) in boxes.iter().enumerate() {
            assert!(a.left() >= 0.0 && a.right() <= 330.0 && a.bottom() <= height, "{a:?}");
            assert!(boxes[i + 1..].iter().all(|b| !a.expand(4.0).intersects(*b)), "{boxes:?}");
        }
        assert!(boxes[0].bottom() < boxes[1].top() && boxes[2].bottom() < boxes[3].top());
        // Three of 90 points do not fit beside each other into 278.
        assert!(boxes[1].top() == boxes[2].top() && boxes[4].top() > boxes[1].top());
    }
}
