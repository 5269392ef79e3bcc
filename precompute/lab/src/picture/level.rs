//! Plans of a level, one a floor.

use super::text::{Align, TextStyle, draw_text};
use super::{Colour, canvas::Picture, colour, furniture::header};
use glam::{Vec2, Vec3, Vec3Swizzles};
use throng_level::Level;

/// Width of a floor's plan, and the largest height (px).
const WIDTH: f32 = 1200.0;
const TALLEST: f32 = 1200.0;
/// Height of the title, and margin (px).
const TOP: f32 = 84.0;
const EDGE: f32 = 16.0;
/// Height by which ground has to differ for another floor (m).
const FLOOR_M: f32 = 1.5;
/// Colours of ground by its part, and of named places.
const GROUND: [u32; 4] = [0xdbe7d3, 0xd3dbe7, 0xe7ddd3, 0xe3d3e7];
const PLACE: Colour = Colour::hex(0xe8c86a);
const WALL: Colour = Colour::hex(0x23282f);

/// Heights of the floors: of level ground, with gaps between (m).
pub fn level_floors(level: &Level) -> Vec<f32> {
    let corners: Vec<Vec3> = level.vertices().collect();
    let heights = |p: u32| {
        let own = level.vertices_of(p).map(|v| corners[v as usize].y);
        own.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)])
    };
    let all = (0..level.num_polygons() as u32).map(heights);
    let mut flat: Vec<f32> = all.clone().filter(|[low, high]| high - low < 0.2).map(|[low, _]| low).collect();
    if flat.is_empty() {
        flat.extend(all.map(|[low, _]| low).reduce(f32::min));
    }
    flat.sort_by(f32::total_cmp);
    let mut out: Vec<f32> = Vec::new();
    for y in flat {
        if out.last().is_none_or(|last| y - last > FLOOR_M) {
            out.push(y);
        }
    }
    out
}

/// Draws the plans of all floors, with places, links and a path if there is one.
pub fn level_sheet(title: &str, level: &Level, path: &[Vec3]) -> Picture {
    let floors = level_floors(level);
    let corners: Vec<Vec3> = level.vertices().collect();
    let bounds = |[low, high]: [Vec2; 2], p: &Vec3| [low.min(p.xz()), high.max(p.xz())];
    let [low, high] = corners.iter().fold([Vec2::INFINITY, Vec2::NEG_INFINITY], bounds);
    let size = (high - low).max(Vec2::ONE);
    let px = ((WIDTH - 2.0 * EDGE) / size.x).min(TALLEST / size.y);
    let row = size.y * px + 2.0 * EDGE;
    let mut page = Picture::new(WIDTH as u32, (TOP + row * floors.len() as f32) as u32, colour::PAPER);
    let subtitle = format!("{:.0} m x {:.0} m, {} floors; walls black, links violet", size.x, size.y, floors.len());
    header(&mut page, 1.0, title, &subtitle);
    // Ground belongs to the highest floor that is not above it.
    let floor_of = |y: f32| floors.iter().rposition(|f| y > f - 0.3).unwrap_or(0);
    for (f, height) in floors.iter().enumerate() {
        let top = TOP + row * f as f32;
        let to_page = |p: Vec2| Vec2::new(EDGE, top + EDGE) + (p - low) * px;
        for p in 0..level.num_polygons() as u32 {
            let own: Vec<Vec3> = level.vertices_of(p).map(|v| corners[v as usize]).collect();
            let mean = own.iter().map(|c| c.y).sum::<f32>() / own.len() as f32;
            if floor_of(mean) != f {
                continue;
            }
            let outline: Vec<Vec2> = own.iter().chain(own.first()).map(|c| to_page(c.xz())).collect();
            let plain = Colour::hex(GROUND[level.component(p) as usize % GROUND.len()]);
            let colour = level.place_of(p).map_or(plain, |_| PLACE);
            // Ramps and stairs are darker the higher they are.
            let up = ((mean - height) / 4.0).clamp(0.0, 0.4);
            page.fill_polygon(&outline, colour.mix(colour::INK_SOFT, up));
            page.stroke_line(&outline, 0.6, colour::PAPER);
        }
        for wall in level.walls() {
            let [from, to] = [wall.from, wall.to].map(Vec3::from);
            if floor_of(0.5 * (from.y + to.y)) == f {
                page.stroke_line(&[to_page(from.xz()), to_page(to.xz())], 1.6, WALL);
            }
        }
        for link in level.links() {
            let [from, to] = link.ends.map(Vec3::from);
            if floor_of(from.y) == f || floor_of(to.y) == f {
                page.stroke_line(&[to_page(from.xz()), to_page(to.xz())], 4.0, colour::MARK);
            }
        }
        for leg in path.windows(2).filter(|leg| floor_of(0.5 * (leg[0].y + leg[1].y)) == f) {
            page.stroke_line(&[to_page(leg[0].xz()), to_page(leg[1].xz())], 3.0, colour::ON_THE_WAY);
        }
        let style = TextStyle { size: 18.0, colour: colour::INK, align: Align::Left, bold: false };
        for place in level.places().filter(|place| floor_of(place.at.y) == f) {
            let at = to_page(place.at.xz());
            page.fill_disc(at, 4.0, colour::INK);
            draw_text(&mut page, at + Vec2::new(8.0, -6.0), place.name, style);
        }
        draw_text(&mut page, Vec2::new(EDGE, top + 4.0), &format!("{height:.1} m"), style);
    }
    page
}
