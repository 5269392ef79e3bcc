//! Records of level files, and their writer.

use bytemuck::{Pod, Zeroable};
use std::io;
use throng_base::frame::{BundleWriter, FileKind, SectionTag};

/// First bytes of every level file.
pub const LEVEL_MAGIC: [u8; 8] = *b"\x89THRLVL\n";
/// The version of level files that this code writes and reads.
pub const LEVEL_VERSION: u32 = 1;
pub(crate) const KIND: FileKind = FileKind { what: "level", magic: LEVEL_MAGIC, version: LEVEL_VERSION };

/// Settings and grid of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LevelHead {
    /// Radius of who walks there: paths keep it from walls (m).
    pub radius_m: f32,
    /// Height of who walks there (m).
    pub height_m: f32,
    /// Highest step (m).
    pub climb_m: f32,
    /// Steepest slope (rad).
    pub slope: f32,
    /// Lowest corner of the grid: x and z (m).
    pub low: [f32; 2],
    /// Side of the grid's squares (m, > 0).
    pub square_m: f32,
    /// Squares along x and z.
    pub squares: [u32; 2],
}

/// Corner of polygons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LevelVertex {
    /// Position (m).
    pub at: [f32; 3],
    /// 1 where walls form a corner that shortest paths bend at, else 0.
    pub is_corner: u32,
}

/// Convex part of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LevelPolygon {
    /// First of its edges, which go round counter-clockwise in the plane of x and z.
    pub first_edge: u32,
    /// Number of edges (>= 3).
    pub num_edges: u32,
    /// First of its triangles, which have its heights.
    pub first_triangle: u32,
    /// Number of triangles (>= 1).
    pub num_triangles: u32,
    /// Number of the connected part of the ground that it belongs to.
    pub component: u32,
    /// Number of the place that it is of; [`crate::NONE`] for plain ground.
    pub place: u32,
    /// Number of edges that lead to other polygons.
    pub num_open: u32,
}

/// Edge of a polygon, from its vertex to that of the next one.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LevelEdge {
    /// Vertex.
    pub vertex: u32,
    /// Polygon on the other side; [`crate::NONE`] at a wall.
    pub neighbour: u32,
    /// Number of the same edge as one of the neighbour's.
    pub twin: u32,
}

/// Named place.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LevelPlace {
    /// Point on the ground (m).
    pub at: [f32; 3],
    /// Range of its kind in the bytes of names: `goal`, `door`, `queue` or `seat`.
    pub kind: [u32; 2],
    /// Range of its name there.
    pub name: [u32; 2],
}

/// Way from a point to another that is not walked, in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LevelLink {
    /// Start and end on the ground (m).
    pub ends: [[f32; 3]; 2],
    /// Polygons of both.
    pub polygons: [u32; 2],
    /// Length of a walk that costs as much (m).
    pub cost_m: f32,
    /// Range of its kind in the bytes of names: `ladder`, `jump`, `climb`, `escalator` or `elevator`.
    pub kind: [u32; 2],
    /// Range of its name there.
    pub name: [u32; 2],
}

/// Border of the ground as it is for somebody without a radius.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LevelWall {
    /// Start (m).
    pub from: [f32; 3],
    /// End (m).
    pub to: [f32; 3],
}

macro_rules! level_sections {
    ($($(#[$doc:meta])* $name:ident: $kind:ty = $tag:literal,)*) => {
        /// Tables of a level, to be written.
        #[derive(Clone, Debug, Default)]
        pub struct LevelData {
            $($(#[$doc])* pub $name: Vec<$kind>,)*
        }

        impl LevelData {
            /// Writes the file.
            ///
            /// # Errors
            /// What `out` returns.
            pub fn write(&self, out: &mut impl io::Write) -> io::Result<()> {
                let mut file = BundleWriter::new();
                $(file.section(SectionTag(*$tag), &self.$name);)*
                file.write_kind(out, KIND)
            }
        }

        /// Tables of a level.
        #[derive(Clone, Debug)]
        pub(crate) struct LevelTables {
            $(pub $name: throng_base::frame::Table<$kind>,)*
            /// Length of the file (bytes).
            pub num_bytes: usize,
        }

        impl LevelTables {
            /// Tables of a file with right checksums.
            pub fn new(
                storage: &std::sync::Arc<throng_base::frame::FileStorage>,
                layout: &throng_base::frame::SectionLayout,
            ) -> Result<Self, throng_base::frame::FormatError> {
                Ok(Self {
                    $($name: throng_base::frame::Table::of_file(storage, &layout.section::<$kind>(SectionTag(*$tag))?),)*
                    num_bytes: storage.bytes().len(),
                })
            }
        }
    };
}

level_sections! {
    /// Settings and grid (one).
    head: LevelHead = b"LHED",
    /// Corners of polygons.
    vertices: LevelVertex = b"LVRT",
    /// Parts of the ground.
    polygons: LevelPolygon = b"LPOL",
    /// Edges of all polygons.
    edges: LevelEdge = b"LEDG",
    /// Triangles of all polygons (m).
    triangles: [[f32; 3]; 3] = b"LTRI",
    /// First entry of each square of the grid in `listed`, and their number at the end.
    squares: u32 = b"LSQR",
    /// Polygons in each square of the grid.
    listed: u32 = b"LLST",
    /// Named places.
    places: LevelPlace = b"LPLC",
    /// Links.
    links: LevelLink = b"LLNK",
    /// Cost of the way from the end of each link to that of another one, over it (m, num_links x num_links).
    link_costs: f32 = b"LCST",
    /// Next link on that way (num_links x num_links).
    link_next: u32 = b"LNXT",
    /// Borders.
    walls: LevelWall = b"LWAL",
    /// Names of places and links.
    names: u8 = b"LNAM",
}
