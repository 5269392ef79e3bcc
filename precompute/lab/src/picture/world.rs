//! Bodies in their surroundings: every pixel shows the nearest surface, with shadows.

use super::furniture::{NamePlates, grid, header, legend, nice_step, page_with_panel, scale_bar};
use super::piece::{PicturePiece, add_solid, add_unit};
use super::text::{Align, TextStyle, draw_text};
use super::{BodyColours, BodyFigure, Colour, Picture, PictureCamera, colour};
use super::{canvas::Area, figure::body_solids, paint::draw_pieces};
use glam::{Vec2, Vec3};
use throng_bake::environment::{PlacedGeometry, UnitGeometry, UnitSolid};
use throng_core::{Joint, patch::Placement};
use throng_geometry::BoundingBox;

/// Colours of units, by their number in the set.
const UNIT_COLOURS: [u32; 8] = [0xb9a58a, 0x8fa3ad, 0xa8b39a, 0xb59a9a, 0x9a9cb8, 0xc0b27e, 0x86a8a0, 0xa79aaf];

/// Colour of the partner of a character.
const PARTNER_COLOUR: Colour = Colour::hex(0x4f9a6b);

/// Least distance in front of the hips, and greatest depth of the top below them, of unit pieces that a strip leaves out (m).
const CUT_BEFORE_HIPS_M: f32 = 0.4;
const CUT_BELOW_HIPS_M: f32 = 0.5;

/// Greatest coordinate of what a view of everything shows (m).
const FARTHEST_M: f32 = 1e5;

/// A body in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldFigure {
    /// The body, in the world.
    pub figure: BodyFigure,
    /// Its colours.
    pub colours: BodyColours,
}

/// A unit in a picture.
#[derive(Clone, Copy, Debug)]
pub struct WorldUnit<'a> {
    /// Shape of the unit.
    pub geometry: &'a UnitGeometry,
    /// Placement of the unit.
    pub placement: Placement,
    /// Its colour.
    pub colour: Colour,
}

/// Colour of the unit with a number in its set; floors are lighter.
pub fn unit_colour(unit: usize, geometry: &UnitGeometry) -> Colour {
    let base = Colour::hex(UNIT_COLOURS[unit % UNIT_COLOURS.len()]);
    if geometry.floor { base.mix(colour::GROUND, 0.55) } else { base }
}

/// The units of an environment, as [`unit_colour`] paints them.
pub fn world_units(environment: &PlacedGeometry) -> Vec<WorldUnit<'_>> {
    let one = |(i, u): (usize, &throng_bake::environment::PlacedUnit)| {
        let geometry = environment.geometry(i);
        WorldUnit { geometry, placement: u.placement, colour: unit_colour(u.unit, geometry) }
    };
    environment.units.iter().enumerate().map(one).collect()
}

/// View of a world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldCamera {
    /// Direction the camera looks in: 0 is +Z, a quarter turn +X (rad).
    pub heading: f32,
    /// Downward tilt: 0 is level, a quarter turn straight down (rad).
    pub elevation: f32,
    /// Point at the centre, and the shown width (m); everything if `None`.
    pub focus: Option<(Vec3, f32)>,
}

/// The usual view of a whole world, obliquely from above.
pub(super) const OBLIQUE_VIEW: WorldCamera =
    WorldCamera { heading: 0.8 * std::f32::consts::PI, elevation: 0.6, focus: None };

/// Input of [`world_sheet`].
#[derive(Clone, Copy, Debug, Default)]
pub struct WorldSheet<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Width and height (px).
    pub size: (u32, u32),
    /// All bodies; those that cannot be drawn are left out.
    pub figures: &'a [WorldFigure],
    /// All units.
    pub units: &'a [WorldUnit<'a>],
    /// Further solids, in the world.
    pub solids: &'a [(UnitSolid, Colour)],
    /// Past or future positions of roots, and their colours (m).
    pub trails: &'a [(Vec<Vec3>, Colour)],
    /// Circles on the ground: centres, radii and colours (m).
    pub rings: &'a [(Vec3, f32, Colour)],
    /// Names above points.
    pub names: &'a [(Vec3, String, Colour)],
    /// Colours and their names, and a remark below them.
    pub legend: (&'a [(Colour, String)], &'a str),
    /// View direction and focus.
    pub camera: WorldCamera,
}

/// Draws bodies among units, in parallel projection; the ground is y = 0.
pub fn world_sheet(view: &WorldSheet<'_>) -> Picture {
    let (mut page, mut panel, at) = page_with_panel(view.size, view.title, view.subtitle);
    let unit = page.width() as f32 / 1600.0;
    let mut pieces = world_pieces(view.units, view.figures);
    view.solids.iter().for_each(|(solid, tint)| add_solid(solid, |p| p, *tint, &mut pieces));
    let extent = Vec2::new(panel.width() as f32, panel.height() as f32);
    let marked = view.trails.iter().flat_map(|t| &t.0).chain(view.rings.iter().map(|r| &r.0));
    let camera = world_camera(&view.camera, extent, &pieces, marked);
    grid(&mut panel, &camera, nice_step(extent.x / camera.px_per_m / 16.0), unit);
    draw_marked(&mut panel, &camera, unit, &pieces, view.trails, view.rings, view.names);
    scale_bar(&mut panel, &camera, unit);
    page.draw_picture(&panel, at);
    let area = Area::new(0.0, 0.0, page.width() as f32 - 16.0 * unit, 84.0 * unit);
    legend(&mut page, area, unit, view.legend.0, view.legend.1);
    page
}

/// Draws pieces, with trails and rings under them and names over them.
fn draw_marked(
    panel: &mut Picture,
    camera: &PictureCamera,
    unit: f32,
    pieces: &[PicturePiece],
    trails: &[(Vec<Vec3>, Colour)],
    rings: &[(Vec3, f32, Colour)],
    names: &[(Vec3, String, Colour)],
) {
    for (points, tint) in trails {
        let points: Vec<Vec2> = points.iter().map(|p| camera.project(*p)).collect();
        panel.stroke_line(&points, 2.0 * unit, tint.alpha(0.7 * tint.a));
    }
    for (centre, radius, tint) in rings {
        panel.stroke_oval(camera.project(*centre), camera.ground_disc(*radius), 1.5 * unit, *tint);
    }
    draw_pieces(panel, camera, pieces);
    let mut tags = NamePlates::default();
    names.iter().for_each(|(at, name, tint)| tags.draw_plate(panel, camera.project(*at), unit, name, *tint));
}

/// A moment of a strip.
#[derive(Clone, Debug, Default)]
pub struct WorldMoment {
    /// Time (s).
    pub time_s: f32,
    /// Bodies.
    pub figures: Vec<WorldFigure>,
    /// Number of framed bodies, from the first: the mean of their hips is at the centre of the picture.
    pub framed: usize,
    /// Further solids at this moment, in the world.
    pub solids: Vec<(UnitSolid, Colour)>,
    /// Past or future positions, and their colours (m).
    pub trails: Vec<(Vec<Vec3>, Colour)>,
    /// Circles on the ground: centres, radii and colours (m).
    pub rings: Vec<(Vec3, f32, Colour)>,
    /// Names above points.
    pub names: Vec<(Vec3, String, Colour)>,
    /// Label in place of the time.
    pub label: Option<String>,
}

impl WorldMoment {
    /// A moment of one body.
    pub fn of_one(time_s: f32, figure: BodyFigure) -> Self {
        let figures = vec![WorldFigure { figure, colours: BodyColours::default() }];
        Self { time_s, figures, framed: 1, ..Self::default() }
    }

    /// A moment of one body, and of its partner, if there is one; both are framed.
    pub fn of_pair(time_s: f32, one: BodyFigure, partner: Option<BodyFigure>) -> Self {
        let mut moment = Self::of_one(time_s, one);
        let colours = BodyColours::plain(PARTNER_COLOUR);
        moment.figures.extend(partner.map(|figure| WorldFigure { figure, colours }));
        Self { framed: moment.figures.len(), ..moment }
    }

    /// Hips of the framed bodies (m).
    fn hips(&self) -> impl Iterator<Item = Vec3> + Clone + '_ {
        self.figures.iter().take(self.framed).map(|f| f.figure.joint(Joint::Hips))
    }
}

/// Input of [`world_strip`].
#[derive(Clone, Copy, Debug, Default)]
pub struct WorldStrip<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Moments.
    pub moments: &'a [WorldMoment],
    /// All units.
    pub units: &'a [WorldUnit<'a>],
    /// Number of moments side by side (>= 1).
    pub columns: usize,
    /// Point at the centre of all moments; the framed bodies of each if `None`.
    pub centre: Option<Vec3>,
    /// Width that a moment shows (m).
    pub width_m: f32,
    /// Height of a moment over its width; 1.25 if 0.
    pub aspect: f32,
    /// View direction: heading and elevation, as in [`WorldCamera`] (rad).
    pub view_angles: (f32, f32),
    /// As in [`WorldSheet`].
    pub legend: (&'a [(Colour, String)], &'a str),
}

/// Draws moments among units, row by row, each with the hips of the framed bodies at its centre. Pieces of units in front of
/// them that reach above the knees are left out.
pub fn world_strip(strip: &WorldStrip<'_>) -> Picture {
    let (width, edge, top, label) = (1600.0, 16.0, 84.0, 28.0);
    let (columns, (heading, elevation)) = (strip.columns.clamp(1, 40), strip.view_angles);
    let cell = (width - 2.0 * edge) / columns as f32;
    let height = cell * if strip.aspect > 0.0 { strip.aspect } else { 1.25 };
    let rows = strip.moments.len().div_ceil(columns).max(1);
    let mut page = Picture::new(width as u32, (top + rows as f32 * (height + label)) as u32 + 8, colour::PAPER);
    header(&mut page, 1.0, strip.title, strip.subtitle);
    legend(&mut page, Area::new(0.0, 0.0, width - edge, top), 1.0, strip.legend.0, strip.legend.1);
    let units = world_pieces(strip.units, &[]);
    for (i, moment) in strip.moments.iter().enumerate() {
        let at = Vec2::new(edge + (i % columns) as f32 * cell, top + (i / columns) as f32 * (height + label));
        let area = Area::new(at.x, at.y, cell - 4.0, height);
        let mut panel = Picture::new(area.size.x as u32, area.size.y as u32, colour::GROUND);
        let num = moment.hips().count();
        let centre = strip.centre.or_else(|| (num > 0).then(|| moment.hips().sum::<Vec3>() / num as f32));
        let focus = centre.map(|centre| (centre, strip.width_m));
        let camera = WorldCamera { heading, elevation, focus };
        let around = world_camera(&camera, area.size, &[], [].iter());
        let hides = |p: &&PicturePiece| {
            let bounds = p.bounds();
            let far = bounds.corners().map(|c| around.depth(c)).into_iter().fold(f32::NEG_INFINITY, f32::max);
            let is_before = |hips: Vec3| far < around.depth(hips) - CUT_BEFORE_HIPS_M;
            moment.hips().any(|hips| bounds.max.y > hips.y - CUT_BELOW_HIPS_M && is_before(hips))
        };
        let mut pieces: Vec<PicturePiece> = units.iter().filter(|p| !hides(p)).copied().collect();
        pieces.extend(world_pieces(&[], &moment.figures));
        moment.solids.iter().for_each(|(solid, tint)| add_solid(solid, |p| p, *tint, &mut pieces));
        let camera = world_camera(&camera, area.size, &pieces, [].iter());
        grid(&mut panel, &camera, nice_step(strip.width_m / 16.0).max(1.0), 0.7);
        draw_marked(&mut panel, &camera, 0.7, &pieces, &moment.trails, &moment.rings, &moment.names);
        if strip.columns <= 2 {
            scale_bar(&mut panel, &camera, 0.8);
        }
        page.draw_picture(&panel, (at.x as i32, at.y as i32));
        let style = TextStyle { size: 18.0, colour: colour::INK, align: Align::Centre, bold: false };
        let label = moment.label.clone().unwrap_or_else(|| format!("{:.2} s", moment.time_s));
        draw_text(&mut page, at + Vec2::new(0.5 * cell, height + 20.0), &label, style);
    }
    page
}

fn world_pieces(units: &[WorldUnit<'_>], figures: &[WorldFigure]) -> Vec<PicturePiece> {
    let mut out = Vec::new();
    units.iter().for_each(|u| add_unit(u.geometry, u.placement, u.colour, &mut out));
    out.extend(figures.iter().flat_map(figure_pieces));
    out
}

/// The pieces of a body; none of one that cannot be drawn.
pub(super) fn figure_pieces(f: &WorldFigure) -> impl Iterator<Item = PicturePiece> + use<> {
    let solids = f.figure.is_drawable().then(|| body_solids(&f.figure, &f.colours));
    solids.into_iter().flatten().map(|(solid, tint)| PicturePiece::round(solid, tint))
}

/// - `marked`: points beside the pieces that are shown, too.
fn world_camera<'a>(
    view: &WorldCamera,
    size: Vec2,
    pieces: &[PicturePiece],
    marked: impl Iterator<Item = &'a Vec3>,
) -> PictureCamera {
    let camera = PictureCamera::looking_along(view.heading, view.elevation.clamp(0.0, std::f32::consts::FRAC_PI_2));
    if let Some((centre, width_m)) = view.focus.filter(|f| f.0.is_finite()) {
        return camera.framed(centre, 0.5 * size, size.x / width_m.clamp(0.5, 10_000.0));
    }
    let corners = pieces.iter().flat_map(|p| p.bounds().corners()).chain(marked.copied());
    let shown: Vec<Vec3> = corners.filter(|c| c.is_finite() && c.abs().max_element() < FARTHEST_M).collect();
    let all = BoundingBox::around_points(shown.iter().copied());
    let all = if all.is_empty() { BoundingBox { min: Vec3::splat(-3.0), max: Vec3::splat(3.0) } } else { all };
    let framed = camera.framed(all.centre(), 0.5 * size, 1.0);
    let reach = shown.iter().map(|c| (framed.project(*c) - framed.screen).abs()).fold(Vec2::splat(1.0), Vec2::max);
    let px_per_m = (0.48 * size / reach).min_element().min(200.0);
    framed.framed(all.centre(), 0.5 * size, px_per_m)
}

#[cfg(test)]
mod tests;
