//! People in their surroundings: every pixel shows what is nearest, shadows fall on what is below.

use super::camera::Camera;
use super::canvas::{Area, Picture, source_over};
use super::colour::{self, Colour};
use super::figure::{BodyColours, Figure, body};
use super::furniture::{grid, header, nice_step, scale_bar, tag};
use super::piece::{Piece, add_unit};
use super::sprite::{light, shade};
use super::text::{Align, TextStyle, draw_text};
use super::visible::{Band, NOTHING, look, sample};
use glam::{Vec2, Vec3};
use std::ops::Range;
use throng_bake::environment::{Bounds, PlacedGeometry, UnitGeometry};
use throng_runtime::Joint;
use throng_runtime::patch::Placement;
use tiny_skia::PremultipliedColorU8;

/// Samples along each side of a pixel.
const RAYS: usize = 3;
/// A step in depth from which a contour is drawn (m).
const CONTOUR_STEP: f32 = 0.07;
/// Longest side of the map of shadows (px).
const SHADOW_PX: f32 = 3000.0;
/// Finest map of shadows (px/m).
const SHADOW_FINEST: f32 = 160.0;
/// Colours of units, by their number in the set.
const UNIT_COLOURS: [u32; 8] = [0xb9a58a, 0x8fa3ad, 0xa8b39a, 0xb59a9a, 0x9a9cb8, 0xc0b27e, 0x86a8a0, 0xa79aaf];

/// A person in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldFigure {
    /// The body, in the world.
    pub figure: Figure,
    /// Its colours.
    pub colours: BodyColours,
}

/// A unit in a picture.
#[derive(Clone, Copy, Debug)]
pub struct WorldUnit<'a> {
    /// Its shape.
    pub geometry: &'a UnitGeometry,
    /// Where it stands.
    pub placement: Placement,
    /// Its colour.
    pub colour: Colour,
}

/// Colour of the unit with that number in its set; what is walked on is lighter.
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

/// From where a world is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldLook {
    /// Direction the camera looks in: 0 is +Z, a quarter turn +X (rad).
    pub heading: f32,
    /// How far it is tilted down: 0 is level, a quarter turn straight down (rad).
    pub elevation: f32,
    /// What is in the middle and the width around it; everything where `None` (m).
    pub focus: Option<(Vec3, f32)>,
}

/// What [`world_sheet`] draws.
#[derive(Clone, Copy, Debug)]
pub struct WorldView<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Width and height (px).
    pub size: (u32, u32),
    /// Everybody; who cannot be drawn is left out.
    pub figures: &'a [WorldFigure],
    /// All that stands around.
    pub units: &'a [WorldUnit<'a>],
    /// Where roots were or will be, and in which colour (m).
    pub trails: &'a [(Vec<Vec3>, Colour)],
    /// Names above points.
    pub names: &'a [(Vec3, String, Colour)],
    /// From where it is seen.
    pub look: WorldLook,
}

/// Draws people among units, in parallel projection; the ground is y = 0.
pub fn world_sheet(view: &WorldView<'_>) -> Picture {
    let mut page = Picture::new(view.size.0, view.size.1, colour::PAPER);
    let unit = page.width() as f32 / 1600.0;
    header(&mut page, unit, view.title, view.subtitle);
    let (edge, top) = ((16.0 * unit) as u32, (84.0 * unit) as u32);
    let size = (page.width().saturating_sub(2 * edge), page.height().saturating_sub(top + edge));
    let mut panel = Picture::new(size.0, size.1, colour::GROUND);
    let pieces = pieces(view.units, view.figures);
    let extent = Vec2::new(panel.width() as f32, panel.height() as f32);
    let camera = camera(&view.look, extent, &pieces);
    grid(&mut panel, &camera, nice_step(extent.x / camera.px_per_m / 16.0), unit);
    draw_pieces(&mut panel, &camera, &pieces);
    for (points, tint) in view.trails {
        let points: Vec<Vec2> = points.iter().map(|p| camera.project(*p)).collect();
        panel.stroke_line(&points, 2.0 * unit, tint.alpha(0.7));
    }
    for (at, name, tint) in view.names {
        tag(&mut panel, camera.project(*at), unit, name, *tint);
    }
    scale_bar(&mut panel, &camera, unit);
    page.draw_picture(&panel, (edge as i32, top as i32));
    page
}

/// What [`world_strip`] draws.
#[derive(Clone, Copy, Debug)]
pub struct WorldStrip<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Moments: time and body (s).
    pub moments: &'a [(f32, Figure)],
    /// All that stands around.
    pub units: &'a [WorldUnit<'a>],
    /// Moments side by side (>= 1).
    pub columns: usize,
    /// Width that a moment shows (m).
    pub width_m: f32,
    /// From where it is seen: heading and elevation, as [`WorldLook`] has them (rad).
    pub from: (f32, f32),
}

/// Draws moments of one person's motion among units, row by row, the hips in the middle of each.
pub fn world_strip(strip: &WorldStrip<'_>) -> Picture {
    let (width, edge, top, label) = (1600.0, 16.0, 84.0, 28.0);
    let columns = strip.columns.clamp(1, 40);
    let cell = (width - 2.0 * edge) / columns as f32;
    let height = 1.25 * cell;
    let rows = strip.moments.len().div_ceil(columns).max(1);
    let mut page = Picture::new(width as u32, (top + rows as f32 * (height + label)) as u32 + 8, colour::PAPER);
    header(&mut page, 1.0, strip.title, strip.subtitle);
    let units = pieces(strip.units, &[]);
    for (i, (time_s, figure)) in strip.moments.iter().enumerate() {
        let at = Vec2::new(edge + (i % columns) as f32 * cell, top + (i / columns) as f32 * (height + label));
        let area = Area::new(at.x, at.y, cell - 4.0, height);
        let mut panel = Picture::new(area.size.x as u32, area.size.y as u32, colour::GROUND);
        let focus = Some((figure.joint(Joint::Hips), strip.width_m));
        let look = WorldLook { heading: strip.from.0, elevation: strip.from.1, focus };
        let body = WorldFigure { figure: *figure, colours: BodyColours::default() };
        let pieces = [&units[..], &super::world::pieces(&[], &[body])].concat();
        let camera = camera(&look, area.size, &pieces);
        grid(&mut panel, &camera, 1.0, 0.7);
        draw_pieces(&mut panel, &camera, &pieces);
        page.draw_picture(&panel, (at.x as i32, at.y as i32));
        let style = TextStyle { size: 18.0, colour: colour::INK, align: Align::Centre, bold: false };
        draw_text(&mut page, at + Vec2::new(0.5 * cell, height + 20.0), &format!("{time_s:.2} s"), style);
    }
    page
}

fn pieces(units: &[WorldUnit<'_>], figures: &[WorldFigure]) -> Vec<Piece> {
    let mut out = Vec::new();
    for u in units {
        add_unit(u.geometry, u.placement, u.colour, &mut out);
    }
    for f in figures.iter().filter(|f| f.figure.is_drawable()) {
        out.extend(body(&f.figure, &f.colours).into_iter().map(|(solid, tint)| Piece::round(solid, tint)));
    }
    out
}

fn camera(view: &WorldLook, size: Vec2, pieces: &[Piece]) -> Camera {
    let camera = Camera::looking(view.heading, view.elevation.clamp(0.0, std::f32::consts::FRAC_PI_2));
    if let Some((centre, width_m)) = view.focus.filter(|f| f.0.is_finite()) {
        return camera.framed(centre, 0.5 * size, size.x / width_m.clamp(0.5, 10_000.0));
    }
    let all = pieces.iter().fold(Bounds::EMPTY, |b, p| b.union(p.bounds()));
    let all = if all.is_empty() { Bounds { min: Vec3::splat(-3.0), max: Vec3::splat(3.0) } } else { all };
    let framed = camera.framed(all.centre(), 0.5 * size, 1.0);
    let reach = pieces.iter().flat_map(|p| p.bounds().corners()).map(|c| (framed.project(c) - framed.screen).abs());
    let reach = reach.fold(Vec2::splat(1.0), Vec2::max);
    let px_per_m = (0.48 * size / reach).min_element().min(200.0);
    framed.framed(all.centre(), 0.5 * size, px_per_m)
}

/// Lays the pieces and their shadows over a panel.
fn draw_pieces(panel: &mut Picture, camera: &Camera, pieces: &[Piece]) {
    let size = Vec2::new(panel.width() as f32, panel.height() as f32);
    let reach = Vec2::splat(2.0 * camera.px_per_m);
    // What is far outside of the picture throws no shadow into it worth its time.
    let near = |p: &&Piece| {
        let (low, high) = p.screen_box(camera);
        high.cmpge(-reach).all() && low.cmple(size + reach).all()
    };
    let pieces: Vec<Piece> = pieces.iter().filter(near).copied().collect();
    let painter = Painter {
        pieces: &pieces,
        camera: *camera,
        light: light(camera),
        shadows: ShadowMap::new(&pieces, light(camera)),
        contour: 1.0 - 0.5 * (camera.px_per_m / 110.0).min(1.0),
    };
    let columns = panel.width() as usize;
    let rows = look(&pieces, camera, (columns, panel.height() as usize), RAYS, 1, |band, pixels| {
        painter.paint(band, pixels, columns)
    });
    for (pixel, top) in panel.pixels_mut().iter_mut().zip(rows.into_iter().flatten()) {
        if top.alpha() > 0 {
            *pixel = source_over(top, *pixel);
        }
    }
}

/// How bands become pixels.
struct Painter<'a> {
    pieces: &'a [Piece],
    camera: Camera,
    light: Vec3,
    shadows: Option<ShadowMap>,
    /// Brightness of contours.
    contour: f32,
}

impl Painter<'_> {
    fn paint(&self, band: &Band, pixels: Range<usize>, columns: usize) -> Vec<PremultipliedColorU8> {
        let mut out = Vec::with_capacity(pixels.len() * columns);
        for y in pixels {
            for x in 0..columns {
                let mut sum = [0.0f32; 4];
                for row in (y * RAYS) as isize..((y + 1) * RAYS) as isize {
                    for column in (x * RAYS) as isize..((x + 1) * RAYS) as isize {
                        let c = self.sample(band, column, row);
                        sum = [sum[0] + c.r * c.a, sum[1] + c.g * c.a, sum[2] + c.b * c.a, sum[3] + c.a];
                    }
                }
                let [r, g, b, a] = sum.map(|v| (v / (RAYS * RAYS) as f32 * 255.0 + 0.5) as u8);
                let c = PremultipliedColorU8::from_rgba(r.min(a), g.min(a), b.min(a), a);
                out.push(c.unwrap_or(PremultipliedColorU8::TRANSPARENT));
            }
        }
        out
    }

    fn sample(&self, band: &Band, x: isize, row: isize) -> Colour {
        let screen = sample(x, row, RAYS);
        let seen = band.at(x, row).filter(|s| s.1 != NOTHING);
        let seen = seen.and_then(|(_, i)| Some((i, self.pieces[i as usize].seen(&self.camera, screen)?)));
        let Some((i, hit)) = seen else {
            let shadow = self.camera.ground(screen).map_or(0.0, |p| self.shadow(p));
            return colour::INK.alpha(0.3 * shadow);
        };
        let p = self.camera.unproject(screen) + self.camera.forward * hit.distance;
        let lit = shade(self.pieces[i as usize].colour, hit.normal, self.light, self.camera.forward);
        let faces_light = (8.0 * hit.normal.dot(self.light)).clamp(0.0, 1.0);
        let dark = 1.0 - 0.34 * faces_light * self.shadow(p + hit.normal * 0.02);
        let k = dark * if self.is_contour(band, x, row, hit.distance) { self.contour } else { 1.0 };
        Colour { r: lit.r * k, g: lit.g * k, b: lit.b * k, a: 1.0 }
    }

    fn shadow(&self, p: Vec3) -> f32 {
        self.shadows.as_ref().map_or(0.0, |s| s.at(p))
    }

    /// True where the surface stands clearly before what is beside it.
    fn is_contour(&self, band: &Band, x: isize, row: isize, depth: f32) -> bool {
        let beside = |(dx, dy): (isize, isize)| band.at(x + dx, row + dy).is_some_and(|s| s.0 > depth + CONTOUR_STEP);
        [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter().any(beside)
    }
}

/// How far light reaches.
struct ShadowMap {
    camera: Camera,
    width: usize,
    /// Depth of what is lit (m, width * height).
    depth: Vec<f32>,
}

impl ShadowMap {
    /// Depths as seen from where the light comes; `None` without pieces.
    fn new(pieces: &[Piece], light: Vec3) -> Option<Self> {
        let all = pieces.iter().fold(Bounds::EMPTY, |b, p| b.union(p.bounds()));
        if all.is_empty() {
            return None;
        }
        let right = light.cross(Vec3::Z).normalize_or(Vec3::X);
        let up = -light.cross(right);
        let seen = Camera { right, up, forward: -light, target: all.centre(), screen: Vec2::ZERO, px_per_m: 1.0 };
        let reach = all.corners().map(|c| seen.project(c).abs()).into_iter().fold(Vec2::splat(0.5), Vec2::max);
        let px_per_m = (0.5 * SHADOW_PX / reach.max_element()).min(SHADOW_FINEST);
        let half = (reach * px_per_m).ceil() + 2.0;
        let size = ((2.0 * half.x) as usize, (2.0 * half.y) as usize);
        let camera = Camera { screen: half, px_per_m, ..seen };
        let rows = look(pieces, &camera, size, 1, 0, |band, _| band.depth.clone());
        Some(Self { camera, width: size.0, depth: rows.concat() })
    }

    /// How much of a point is in the shadow: 0 to 1.
    fn at(&self, p: Vec3) -> f32 {
        let (screen, depth) = (self.camera.project(p), self.camera.depth(p));
        // Flat ground is deeper from one sample to the next; so much is no shadow.
        let bias = 0.015 + 1.5 / self.camera.px_per_m;
        let mut dark = 0.0;
        for dy in -1..=1 {
            for dx in -1..=1 {
                let (x, y) = (screen.x.floor() + dx as f32, screen.y.floor() + dy as f32);
                if x >= 0.0 && y >= 0.0 && (x as usize) < self.width {
                    let lit = self.depth.get(y as usize * self.width + x as usize).copied().unwrap_or(f32::INFINITY);
                    dark += if lit < depth - bias { 1.0 } else { 0.0 };
                }
            }
        }
        dark / 9.0
    }
}

#[cfg(test)]
mod tests;
