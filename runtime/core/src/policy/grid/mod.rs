//! The grid of target cells around a character: rings x angles (x heights) (Lee and Lee 2004, section 3 and figure 3).

mod stencil;

use super::maths::{angle_of, nearest_index, split_interval};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::f32::consts::{PI, TAU};
pub use stencil::Stencil;
pub(super) use stencil::{GridCoordinates, StencilLanes, interval};
use throng_base::error::{check_index, check_value};
use throng_base::{Result, maths};

/// [`GridRecord::kind`] of a polar grid: angles cover the full circle, one height, farther targets clamp to the last
/// ring.
pub const KIND_POLAR: u32 = 0;
/// [`GridRecord::kind`] of a cylinder sector: angles between two bounds, several heights.
pub const KIND_CYLINDER: u32 = 1;
/// [`GridRecord::kind`] of a space-time grid: polar, with the time left until an event in place of the height.
pub const KIND_SPACE_TIME: u32 = 2;
/// Most cells a grid may have along one axis.
pub const MAX_AXIS: u32 = 4096;

/// Most cells of a grid, which are counted with 32 bits.
const MOST_CELLS: f64 = (1u64 << 31) as f64;

/// A grid as stored. Ring k lies at `ring_start + ring_spacing k + ring_growth k^2`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GridRecord {
    /// [`KIND_POLAR`], [`KIND_CYLINDER`] or [`KIND_SPACE_TIME`].
    pub kind: u32,
    /// Rings (2 to 4096).
    pub num_rings: u32,
    /// Angles (2 to 4096).
    pub num_angles: u32,
    /// Heights; 1 if the height does not matter (1 to 4096).
    pub num_heights: u32,
    /// Radius of ring 0 (m, >= 0).
    pub ring_start: f32,
    /// See the type (m, > 0).
    pub ring_spacing: f32,
    /// See the type; 0 for rings at equal distances (m, >= 0).
    pub ring_growth: f32,
    /// First angle, from straight ahead (+Z) towards +X; 0 for a polar grid (rad).
    pub angle_start: f32,
    /// Between angles; 2 pi / num_angles for a polar grid (rad, > 0).
    pub angle_spacing: f32,
    /// First height above the ground; on a space-time grid the first time left (m, or s).
    pub height_start: f32,
    /// Between heights, or times (m, or s, > 0).
    pub height_spacing: f32,
    /// Distance beyond the grid over which values fall to about 1/e (m, > 0).
    pub falloff: f32,
}
const _: () = assert!(size_of::<GridRecord>() == 48);

/// A checked grid of target cells around a character, in its frame: +Z ahead, +X left, Y the height above ground.
///
/// Cells are numbered `(height * num_rings + ring) * num_angles + angle`. A *polar* grid covers the full circle; a
/// *cylinder* covers a sector of angles, distances and heights, as Lee and Lee (2004) use for punches. A *space-time*
/// grid covers the full circle too; its third axis is the time left until an event at the target. Y of a target is that
/// time then (s).
///
/// Beyond the grid: a **target** is clamped to the grid along each axis, so that its direction still counts at any
/// distance. The **target after an action**, where a value is read, may then lie slightly outside. There the value of
/// the nearest point is multiplied by 1 / (1 + u + u^2/2), close to exp(-u), where u is the distance beyond the grid
/// over `falloff`. An action that leads away is thus worth less than one that leads nearer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetGrid {
    record: GridRecord,
    radius: f32,
    angles_per_radian: f32,
    heights_per_metre: f32,
    inverse_falloff: f32,
    /// Number of angles, index of the last ring, and indices of the last intervals, as floats.
    pub(in crate::policy) angles: f32,
    last_ring: f32,
    last_intervals: [f32; 2],
    /// Square of the ring spacing, and four times the growth.
    ring_root: [f32; 2],
}

impl TargetGrid {
    /// A polar grid of `num_rings` from the character itself to `radius` (m).
    ///
    /// - `inner_spacing`: between the first two rings; `radius / (num_rings - 1)` gives rings at equal distances, less
    ///   makes the distances grow outwards (m, > radius / (num_rings - 1)^2).
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] names what is out of its range.
    pub fn polar(num_rings: u32, num_angles: u32, radius: f32, inner_spacing: f32, falloff: f32) -> Result<Self> {
        let last = num_rings.max(2) as f32 - 1.0;
        let share = radius / last;
        let good = num_rings <= 2 || inner_spacing > share / last && inner_spacing <= share * 1.0001;
        let expected = "above radius / (rings - 1)^2 and at most radius / (rings - 1)";
        check_value("grid inner_spacing", None, inner_spacing, good, expected)?;
        // spacing + growth = inner_spacing, spacing last + growth last^2 = radius.
        let growth = ((radius - inner_spacing * last) / (last * (last - 1.0)).max(1.0)).max(0.0);
        let growth = if num_rings > 2 && growth > 1e-6 * radius { growth } else { 0.0 };
        let spacing = share - growth * last;
        Self::new(GridRecord {
            kind: KIND_POLAR,
            num_rings,
            num_angles,
            num_heights: 1,
            ring_spacing: spacing,
            ring_growth: growth,
            angle_spacing: TAU / num_angles.max(1) as f32,
            height_spacing: 1.0,
            falloff,
            ..GridRecord::default()
        })
    }

    /// A cylinder sector: `[num_angles, num_rings, num_heights]` cells whose centres span `min..=max`, both given as
    /// (angle, distance, height) (rad, m, m).
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] names what is out of its range.
    pub fn cylinder(counts: [u32; 3], min: Vec3, max: Vec3, falloff: f32) -> Result<Self> {
        let step = |i: usize| (max[i] - min[i]) / (counts[i].max(2) - 1) as f32;
        Self::new(GridRecord {
            kind: KIND_CYLINDER,
            num_rings: counts[1],
            num_angles: counts[0],
            num_heights: counts[2],
            ring_start: min.y,
            ring_spacing: step(1),
            ring_growth: 0.0,
            angle_start: min.x,
            angle_spacing: step(0),
            height_start: min.z,
            height_spacing: if counts[2] > 1 { step(2) } else { 1.0 },
            falloff,
        })
    }

    /// A space-time grid: a polar grid of equal distances to `radius` times the times from 0 to `horizon_s`.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] names what is out of its range.
    pub fn space_time(counts: [u32; 3], radius: f32, horizon_s: f32, falloff: f32) -> Result<Self> {
        let [num_rings, num_angles, num_heights] = counts;
        let polar = Self::polar(num_rings, num_angles, radius, radius / (num_rings.max(2) - 1) as f32, falloff)?;
        let height_spacing = horizon_s / (num_heights.max(2) - 1) as f32;
        Self::new(GridRecord { kind: KIND_SPACE_TIME, num_heights, height_spacing, ..polar.record })
    }

    /// Checks a stored grid.
    ///
    /// # Errors
    /// [`throng_base::Error::Index`] for an unknown kind, [`throng_base::Error::Value`] for counts, lengths and angles out of range.
    pub fn new(record: GridRecord) -> Result<Self> {
        let counts = [record.num_rings, record.num_angles, record.num_heights];
        let names = ["grid rings", "grid angles", "grid heights"];
        for ((what, n), least) in names.into_iter().zip(counts).zip([2, 2, 1]) {
            check_value(what, None, n, (least..=MAX_AXIS).contains(&n), "2 (1 height) to 4096")?;
        }
        let cells: f64 = counts.iter().map(|&n| f64::from(n)).product();
        check_value("grid cells", None, cells, cells <= MOST_CELLS, "at most 2^31")?;
        check_index("grid kind", None, record.kind as usize, KIND_SPACE_TIME as usize + 1)?;
        check_lengths(&record)?;
        Ok(Self::from_record(record))
    }

    /// The grid of a sound record.
    fn from_record(record: GridRecord) -> Self {
        let last = record.num_rings as f32 - 1.0;
        Self {
            record,
            radius: record.ring_start + last * (record.ring_spacing + record.ring_growth * last),
            angles_per_radian: record.angle_spacing.recip(),
            heights_per_metre: record.height_spacing.recip(),
            inverse_falloff: record.falloff.recip(),
            angles: record.num_angles as f32,
            last_ring: last,
            last_intervals: [last - 1.0, (record.num_angles - if goes_around(record.kind) { 1 } else { 2 }) as f32],
            ring_root: [record.ring_spacing * record.ring_spacing, 4.0 * record.ring_growth],
        }
    }

    /// A grid over the same region with other counts. A single height stands for all.
    ///
    /// - `counts`: rings, angles, heights, within the limits of [`GridRecord`].
    pub fn with_counts(&self, counts: [u32; 3]) -> Self {
        let r = self.record;
        let [num_rings, num_angles, num_heights] = counts;
        // Ring coordinates scale, so that growing distances keep growing.
        let rings = ratio(r.num_rings - 1, num_rings - 1);
        let (old, new) = if self.is_polar() { (r.num_angles, num_angles) } else { (r.num_angles - 1, num_angles - 1) };
        Self::from_record(GridRecord {
            num_rings,
            num_angles,
            num_heights,
            ring_spacing: r.ring_spacing * rings,
            ring_growth: r.ring_growth * (rings * rings),
            angle_spacing: r.angle_spacing * ratio(old, new),
            height_spacing: r.height_spacing
                * if num_heights > 1 { ratio(r.num_heights - 1, num_heights - 1) } else { 1.0 },
            ..r
        })
    }

    /// Numbers of rings, angles and heights.
    pub fn counts(&self) -> [u32; 3] {
        [self.record.num_rings, self.record.num_angles, self.record.num_heights]
    }

    /// The grid as stored.
    pub fn record(&self) -> &GridRecord {
        &self.record
    }

    /// Number of cells.
    pub fn num_cells(&self) -> usize {
        self.num_plane_cells() * self.record.num_heights as usize
    }

    /// Number of cells of one height: rings x angles.
    pub fn num_plane_cells(&self) -> usize {
        (self.record.num_rings * self.record.num_angles) as usize
    }

    /// True if angles cover the full circle: polar and space-time grids.
    pub fn is_polar(&self) -> bool {
        goes_around(self.record.kind)
    }

    /// True if the third axis is the time left.
    pub fn is_space_time(&self) -> bool {
        self.record.kind == KIND_SPACE_TIME
    }

    /// Radius of the outermost ring (m).
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Angle, distance and height (or time left) of a cell's centre (rad, m, m or s, cell < num_cells).
    pub fn cell_coordinates(&self, cell: usize) -> Vec3 {
        let r = &self.record;
        let angle = cell % r.num_angles as usize;
        let ring = (cell / r.num_angles as usize % r.num_rings as usize) as f32;
        let height = cell / self.num_plane_cells();
        let a = r.angle_start + angle as f32 * r.angle_spacing;
        let a = if self.is_polar() && a > PI { a - TAU } else { a };
        let radius = r.ring_start + ring * (r.ring_spacing + r.ring_growth * ring);
        Vec3::new(a, radius, r.height_start + height as f32 * r.height_spacing)
    }

    /// A cell's centre in the character's frame (m, cell < num_cells).
    pub fn cell_centre(&self, cell: usize) -> Vec3 {
        let c = self.cell_coordinates(cell);
        Vec3::new(c.y * maths::sin(c.x), c.z, c.y * maths::cos(c.x))
    }

    /// True if the grid contains a target, so that nothing is clamped.
    pub fn contains(&self, target: Vec3) -> bool {
        let r = &self.record;
        let distance = maths::hypot(target.x, target.z);
        let within = |v: f32, start: f32, spacing: f32, n: u32| v >= start && v <= start + spacing * (n - 1) as f32;
        let angle =
            self.is_polar() || within(angle_of(target.x, target.z), r.angle_start, r.angle_spacing, r.num_angles);
        let height = r.kind == KIND_POLAR || within(target.y, r.height_start, r.height_spacing, r.num_heights);
        angle && height && distance >= r.ring_start && distance <= self.radius
    }

    /// Clamps a target to the grid: distance first, then (in a cylinder) angle and height.
    #[inline]
    pub fn clamp(&self, target: Vec3) -> Vec3 {
        let distance = (target.x * target.x + target.z * target.z).sqrt();
        let r = &self.record;
        if self.is_polar() {
            let shrink = if distance > self.radius { self.radius / distance } else { 1.0 };
            let top = if r.num_heights > 1 { r.height_spacing * (r.num_heights - 1) as f32 } else { 0.0 };
            return Vec3::new(target.x * shrink, target.y.clamp(0.0, top), target.z * shrink);
        }
        let last = |start: f32, spacing: f32, n: u32| start + spacing * (n - 1) as f32;
        let distance = distance.clamp(r.ring_start, self.radius);
        let middle = 0.5 * (r.angle_start + last(r.angle_start, r.angle_spacing, r.num_angles));
        let angle = middle + crate::planar::wrap_angle(angle_of(target.x, target.z) - middle);
        let angle = angle.clamp(r.angle_start, last(r.angle_start, r.angle_spacing, r.num_angles));
        let height = target.y.clamp(r.height_start, last(r.height_start, r.height_spacing, r.num_heights));
        Vec3::new(distance * maths::sin(angle), height, distance * maths::cos(angle))
    }

    /// The cell nearest to a target: nearest ring, angle and height, each clamped.
    #[inline]
    pub fn nearest_cell(&self, target: Vec3) -> usize {
        let r = &self.record;
        let distance = (target.x * target.x + target.z * target.z).sqrt();
        let last_ring = r.num_rings - 1;
        let ring = nearest_index(self.ring_number(distance).min(last_ring as f32), last_ring);
        let angle = self.angle_number(angle_of(target.x, target.z));
        let angle = if self.is_polar() {
            let a = nearest_index(angle, r.num_angles);
            if a == r.num_angles { 0 } else { a }
        } else {
            nearest_index(angle.clamp(0.0, (r.num_angles - 1) as f32), r.num_angles - 1)
        };
        let (height, ratio) = self.height_interval(target.y);
        let height = if ratio > 0.5 { height + 1 } else { height };
        ((height * r.num_rings + ring) * r.num_angles + angle) as usize
    }

    /// Lower height of the interval that contains `y`, and the ratio within it; clamped, (0, 0) if there is one height.
    #[inline]
    pub fn height_interval(&self, y: f32) -> (u32, f32) {
        let n = self.record.num_heights;
        if n == 1 {
            return (0, 0.0);
        }
        let t = ((y - self.record.height_start) * self.heights_per_metre).clamp(0.0, (n - 1) as f32);
        split_interval(t, n - 2)
    }
}

/// Ratio of two counts.
fn ratio(a: u32, b: u32) -> f32 {
    a as f32 / b as f32
}

/// True for kinds whose angles cover the full circle.
fn goes_around(kind: u32) -> bool {
    kind != KIND_CYLINDER
}

/// Checks the lengths and angles of a record whose counts are in range.
fn check_lengths(r: &GridRecord) -> Result<()> {
    for (what, v) in [
        ("grid ring_spacing", r.ring_spacing),
        ("grid angle_spacing", r.angle_spacing),
        ("grid height_spacing", r.height_spacing),
        ("grid falloff", r.falloff),
    ] {
        check_value(what, None, v, v > 1e-6 && v < 1e6, "between 1e-6 and 1e6")?;
    }
    for (what, v) in [("grid ring_start", r.ring_start), ("grid ring_growth", r.ring_growth)] {
        check_value(what, None, v, (0.0..1e6).contains(&v), "between 0 and 1e6")?;
    }
    check_value("grid height_start", None, r.height_start, r.height_start.abs() <= 1e6, "between -1e6 and 1e6")?;
    let (start, spacing) = (r.angle_start, r.angle_spacing);
    if !goes_around(r.kind) {
        let good = start.abs() <= PI && spacing * ((r.num_angles - 1) as f32) < TAU;
        return check_value("grid angle_start", None, start, good, "in [-pi, pi], with less than a full turn covered");
    }
    let is_whole = (spacing * r.num_angles as f32 - TAU).abs() <= 1e-4;
    check_value("grid angle_spacing", None, spacing, is_whole, "2 pi / num_angles")?;
    let heights = if r.kind == KIND_POLAR { r.num_heights == 1 } else { r.num_heights > 1 };
    let good = start == 0.0 && heights && r.height_start == 0.0;
    let expected = "0, with one height, or several times from 0, as a grid over the full circle has";
    check_value("grid angle_start", None, start, good, expected)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub fn polar([rings, angles]: [u32; 2], radius: f32, inner_spacing: f32) -> TargetGrid {
        TargetGrid::polar(rings, angles, radius, inner_spacing, 2.5).expect("a valid grid")
    }

    /// Ahead, between some distances and heights.
    pub fn sector(counts: [u32; 3], falloff: f32) -> TargetGrid {
        let [low, high] = [Vec3::new(-1.1, 0.3, 1.2), Vec3::new(1.3, 1.3, 1.6)];
        TargetGrid::cylinder(counts, low, high, falloff).expect("a valid grid")
    }

    fn grids() -> [TargetGrid; 3] {
        [polar([16, 32], 8.0, 0.25), polar([5, 13], 2.0, 0.5), sector([10, 10, 4], 0.1)]
    }

    #[test]
    fn a_grid_of_more_cells_than_are_counted_is_refused() {
        let grid = |heights| TargetGrid::cylinder([4096, 4096, heights], Vec3::ZERO, Vec3::new(1.0, 5000.0, 2.0), 0.5);
        assert!(grid(128).is_ok());
        assert!(grid(256).unwrap_err().to_string().starts_with("grid cells is 4294967296, expected at most 2^31"));
    }

    #[test]
    fn record_keeps_the_given_radii() {
        let g = TargetGrid::polar(16, 32, 8.0, 0.25, 2.5).expect("a valid grid");
        assert!((g.radius() - 8.0).abs() < 1e-4);
        assert!((g.cell_coordinates(32).y - 0.25).abs() < 1e-5);
        let g = TargetGrid::polar(5, 13, 2.0, 0.5, 2.5).expect("a valid grid");
        assert_eq!(g.record().ring_growth, 0.0);
        assert!((g.cell_coordinates(13 * 3).y - 1.5).abs() < 1e-6);
    }

    #[test]
    fn centre_of_a_cell_maps_to_the_cell_and_gives_it_all_the_weight() {
        for g in grids() {
            for cell in 0..g.num_cells() {
                let c = g.cell_centre(cell);
                let s = g.stencil(c.x, c.z);
                let mut values = vec![0.0; g.num_plane_cells()];
                values[cell % g.num_plane_cells()] = 1.0;
                let at_centre = s.interpolate(&values, g.record().num_angles);
                if g.cell_coordinates(cell).y > 0.0 {
                    assert_eq!(g.nearest_cell(c), cell);
                    assert!(at_centre > 0.998, "{cell} {at_centre}");
                } else {
                    assert_eq!(g.nearest_cell(c) / g.record().num_angles as usize, 0);
                }
            }
        }
    }

    #[test]
    fn angles_wrap_behind_the_character() {
        let g = TargetGrid::polar(5, 12, 2.0, 0.5, 2.5).expect("a valid grid");
        let behind = |a: f32| g.nearest_cell(Vec3::new(a.sin(), 0.0, a.cos()));
        assert_eq!(behind(3.1), behind(-3.1));
        let just_right_of_ahead = g.stencil(-1e-4, 1.0);
        assert_eq!((just_right_of_ahead.angle, just_right_of_ahead.next_angle), (11, 0));
        assert_eq!(g.nearest_cell(Vec3::new(-1e-4, 0.0, 1.0)), 24);
    }

    #[test]
    fn beyond_the_last_ring_direction_counts_and_the_value_falls_with_distance() {
        let g = TargetGrid::polar(5, 12, 2.0, 0.5, 2.5).expect("a valid grid");
        let t = g.clamp(Vec3::new(300.0, 1.0, 400.0));
        assert!((t - Vec3::new(1.2, 0.0, 1.6)).length() < 1e-5);
        let values = vec![1.0; g.num_cells()];
        let at = |z: f32| g.stencil(0.0, z).interpolate(&values, 12);
        assert!((at(2.0) - 1.0).abs() < 1e-6 && at(2.5) < 1.0 && at(3.0) < at(2.5) && at(50.0) > 0.0);
    }

    #[test]
    fn refuses_numbers_out_of_range() {
        let good = *grids()[0].record();
        let spoil = |f: &dyn Fn(&mut GridRecord)| {
            let mut r = good;
            f(&mut r);
            TargetGrid::new(r).is_err()
        };
        assert!(spoil(&|r| r.num_rings = 1));
        assert!(spoil(&|r| r.num_angles = 5000));
        assert!(spoil(&|r| r.kind = KIND_SPACE_TIME + 1));
        assert!(spoil(&|r| r.falloff = f32::NAN));
        assert!(spoil(&|r| r.ring_spacing = f32::INFINITY));
        assert!(spoil(&|r| r.angle_spacing *= 0.9));
        assert!(TargetGrid::polar(8, 8, f32::NAN, 0.1, 1.0).is_err());
        assert!(TargetGrid::polar(0, 0, 1.0, 0.1, 1.0).is_err());
    }

    proptest! {
        #[test]
        fn weights_sum_to_one_within_and_interpolate_a_linear_function(a in -3.1f32..3.1, r in 0.0f32..2.0) {
            let [_, g, sector] = grids();
            let (x, z) = (r * a.sin(), r * a.cos());
            let ones = vec![1.0; g.num_cells()];
            prop_assert!((g.stencil(x, z).interpolate(&ones, 13) - 1.0).abs() < 1e-6);
            let radii: Vec<f32> = (0..g.num_cells()).map(|c| g.cell_coordinates(c).y).collect();
            prop_assert!((g.stencil(x, z).interpolate(&radii, 13) - r).abs() < 1e-5);
            let t = Vec3::new(x, 1.4, z);
            let plane = vec![1.0; sector.num_plane_cells()];
            let weight = sector.stencil(x, z).interpolate(&plane, 10);
            prop_assert_eq!(weight > 1.0 - 1e-6, sector.contains(t) || weight == 1.0);
            let c = sector.clamp(t);
            prop_assert!(sector.stencil(c.x, c.z).interpolate(&plane, 10) > 0.999);
        }

        #[test]
        fn any_position_gives_a_cell_in_range(x in any::<f32>(), y in any::<f32>(), z in any::<f32>()) {
            for g in grids() {
                prop_assert!(g.nearest_cell(Vec3::new(x, y, z)) < g.num_cells());
                let s = g.stencil(x, z);
                prop_assert!(s.ring + 1 < g.record().num_rings && s.next_angle < g.record().num_angles);
            }
        }
    }
}
