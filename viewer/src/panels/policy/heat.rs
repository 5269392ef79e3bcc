//! The picture of a state's values over the target grid, kept until it changes.

use super::chart::{PolicyChart, polar};
use crate::theme::viridis;
use eframe::egui::epaint::Mesh;
use eframe::egui::{Color32, Pos2, Rect, vec2};
use glam::Vec2;
use std::{collections::HashSet, f32::consts::TAU, sync::Arc};
use throng_core::{graph::MotionGraph, policy::PolicyTable};

/// Longest piece of an arc that is drawn straight (rad).
const ARC: f32 = TAU / 90.0;
/// Longest arrow (points).
const LONGEST: f32 = 22.0;
/// Space between the feet of arrows (points).
const APART: f32 = 17.0;

/// Key of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatKey {
    /// Generation of the document.
    pub document: u64,
    /// Behaviour.
    pub policy: usize,
    /// State.
    pub state: u32,
    /// Height of the targets, or time left.
    pub height: u32,
    /// Part of the screen.
    pub rect: Rect,
    /// Space around it, for the words "ahead" and so on (points).
    pub margin: f32,
}

/// Maps the ground around the character to the screen. Places are in the frame of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapProjection {
    /// Screen position of the grid's centre.
    origin: Pos2,
    /// Points that a metre takes.
    pub per_m: f32,
    /// Screen position of the character.
    pub character: Pos2,
}

impl MapProjection {
    /// Fits a chart and the character into a part of the screen.
    ///
    /// - `centre`: centre of the grid relative to the character (m).
    /// - `margin`: left free on all sides (points).
    pub fn new(chart: &PolicyChart, centre: Vec2, rect: Rect, margin: f32) -> Self {
        let [low, high] = chart.bounds(-centre);
        let (room, size) = (rect.shrink(margin), high - low);
        let per_m = (room.width() / size.x).min(room.height() / size.y).max(1.0);
        let middle = 0.5 * (low + high);
        let origin = rect.center() + vec2(middle.x, middle.y) * per_m;
        let mut plan = Self { origin, per_m, character: origin };
        plan.character = plan.screen(-centre);
        plan
    }

    /// Screen position of a place: the character's left is at the left, ahead is up.
    pub fn screen(&self, p: Vec2) -> Pos2 {
        Pos2::new(self.origin.x - p.x * self.per_m, self.origin.y - p.y * self.per_m)
    }

    /// Place of a screen position.
    pub fn ground(&self, p: Pos2) -> Vec2 {
        Vec2::new(self.origin.x - p.x, self.origin.y - p.y) / self.per_m
    }
}

/// The picture.
#[derive(Clone, Debug)]
pub struct HeatPicture {
    /// Key that the picture was computed for.
    pub key: HeatKey,
    /// Places on the screen.
    pub plan: MapProjection,
    /// Coloured sectors.
    pub mesh: Arc<Mesh>,
    /// Least and largest value of the state.
    pub range: [f32; 2],
    /// Feet and tips of the arrows.
    pub arrows: Vec<[Pos2; 2]>,
    /// Length of arrows against the distance on the map.
    pub arrow_scale: f32,
}

impl HeatPicture {
    /// Works the picture out.
    pub fn new(key: HeatKey, policy: &PolicyTable, graph: &MotionGraph) -> Self {
        let chart = PolicyChart::new(&policy.grid_of(key.state));
        let centre = policy.centre();
        let plan = MapProjection::new(&chart, Vec2::new(centre.x, centre.z), key.rect, key.margin);
        let values = policy.values_of(key.state);
        let range = values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], &v| [a.min(v), b.max(v)]);
        let colour = |v: f32| viridis::map(viridis::ratio(v, range));
        let mesh = cells(&chart, &plan, key.height, |cell| colour(values[cell]));
        let mut picture = Self { key, plan, mesh: Arc::new(mesh), range, arrows: Vec::new(), arrow_scale: 1.0 };
        picture.add_arrows(&chart, policy, graph);
        picture
    }

    /// Adds arrows of the best actions of cells, for as many cells as there is room for.
    fn add_arrows(&mut self, chart: &PolicyChart, policy: &PolicyTable, graph: &MotionGraph) {
        let (key, plan) = (self.key, self.plan);
        let segments = graph.segments_of(key.state);
        let direction = |cell: usize| {
            let best = usize::from(policy.best_of(key.state, cell)[0]);
            let d = graph.segments[segments[best] as usize].displacement;
            Vec2::new(d[0], d[1])
        };
        let longest = chart.cells(key.height).map(|c| direction(c).length()).fold(0.0, f32::max) * plan.per_m;
        self.arrow_scale = if longest > LONGEST { LONGEST / longest } else { 1.0 };
        let mut taken = HashSet::new();
        for cell in chart.cells(key.height).rev() {
            let centre = policy.grid_of(key.state).cell_centre(cell);
            let foot = plan.screen(Vec2::new(centre.x, centre.z));
            let bucket = ((foot.x / APART) as i32, (foot.y / APART) as i32);
            let mut around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| (bucket.0 + x, bucket.1 + y)));
            let is_near = |b| taken.contains(&b) && self.arrows.iter().any(|a| a[0].distance(foot) < APART);
            if around.any(is_near) {
                continue;
            }
            taken.insert(bucket);
            let direction = direction(cell) * self.arrow_scale;
            let tip = Pos2::new(foot.x - direction.x * plan.per_m, foot.y - direction.y * plan.per_m);
            self.arrows.push([foot, tip]);
        }
    }
}

/// Sectors of one colour each.
fn cells(chart: &PolicyChart, plan: &MapProjection, height: u32, colour: impl Fn(usize) -> Color32) -> Mesh {
    let mut mesh = Mesh::default();
    for cell in chart.cells(height) {
        let sector = chart.sector(cell);
        let [from, to] = sector.angles;
        let parts = ((to - from) / ARC).ceil().max(1.0) as usize;
        let colour = colour(cell);
        let first = mesh.vertices.len() as u32;
        for radius in sector.radii {
            for i in 0..=parts {
                let angle = from + (to - from) * i as f32 / parts as f32;
                mesh.colored_vertex(plan.screen(polar(angle, radius)), colour);
            }
        }
        stitch(&mut mesh, first, parts as u32);
    }
    mesh
}

/// Triangles between two consecutive rows of vertices.
fn stitch(mesh: &mut Mesh, first: u32, parts: u32) {
    for i in first..first + parts {
        let above = i + parts + 1;
        mesh.add_triangle(i, i + 1, above);
        mesh.add_triangle(i + 1, above, above + 1);
    }
}
