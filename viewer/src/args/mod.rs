//! The command line of `throng-viewer`.

mod parse;
mod scene;

pub use parse::{AdapterChoice, BodyChoice, CameraArg, PanelChoice, PictureSize, ThemeName};

use crate::command::ViewStage;
use std::path::PathBuf;
use throng_core::base::limits::{self, number_parser};
use throng_crowd::Scheme;

/// Frames that run before a picture, unless given (1/60 s).
pub const PICTURE_FRAMES: u32 = 150;

/// Heading of the arguments that need no screen.
const SCREENLESS: &str = "Without a screen";
const AFTER_HELP: &str = "\
JSON keys: with --png file, characters, frames, adapter, width, height, simulation_ms, layout_ms, upload_ms, drawing_ms, \
interface_ms, frame_ms (medians of the frames that ran), and simulation_p95_ms to frame_p95_ms (their 95th percentiles). \
`characters` is 0 where a clip is shown.

Exit codes: 0 done, 1 failed (the message names what and the way out), 2 wrong usage.

Examples:
  throng-viewer FOLDER
  throng-viewer data/scenes/corridor.toml --engine occupancy
  throng-viewer walk.throng --png crowd.png --characters 1000 --panel none --camera yaw=30,pitch=20,distance=25
  throng-viewer walk.throng --png crowd.png --characters 10000 --frames 60 --json";

/// Shows what is baked, and lets it be tried: bundles (*.throng), scenes, worlds and tasks of limbs (*.toml), motion files (*.bvh, *.amc,
/// *.npz, *.glb, *.gltf, *.fbx), and folders and archives (*.zip) of motion, which are built first, into the cache.
///
/// Opens a window, in which H lists the keys; without a file, its start page. With --png it needs no screen.
#[derive(clap::Parser, Clone, Debug, Default)]
#[command(name = "throng-viewer", version, after_help = AFTER_HELP)]
pub struct Args {
    /// Bundle, scene, world of motion patches, task of limbs, motion file, or folder or archive of motion; the start page where absent.
    pub file: Option<PathBuf>,

    /// Draw a picture instead of opening a window.
    #[arg(long, value_name = "OUT", help_heading = SCREENLESS)]
    pub png: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long, requires = "png", help_heading = SCREENLESS)]
    pub json: bool,
    /// Graphics adapter: `software` draws the same everywhere, `any` takes the fastest.
    #[arg(long, value_enum, default_value_t, value_name = "WHICH", requires = "png", help_heading = SCREENLESS)]
    pub adapter: AdapterChoice,

    /// Read only files beside a stranger's scene or below, and build nothing.
    #[arg(long)]
    pub untrusted: bool,
    /// Size of the picture or the window. [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = parse::size)]
    pub size: Option<PictureSize>,
    /// Scale of text and everything else, 0.5 to 3.
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = number_parser::<f32>(&limits::SCALE))]
    pub scale: Option<f32>,
    /// Frames of 1/60 s that run before the picture [default: 150]; a window closes after so many, not counting those in
    /// which something is built.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number_parser::<u32>(&limits::FRAMES))]
    pub frames: Option<u32>,
    /// Dark or light.
    #[arg(long, value_enum)]
    pub theme: Option<ThemeName>,
    /// Camera: front, side, top or three-quarter, or settings such as
    /// `yaw=30,pitch=20,distance=6,target=0:1:0,fov=35` (angles in degrees), or both. Without distance and target,
    /// all is in the picture.
    #[arg(long, value_name = "SPEC")]
    pub camera: Option<CameraArg>,
    /// Panels that are open, with commas; `none` for none, and in a picture for the 3-D view alone.
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = parse::panel)]
    pub panel: Vec<PanelChoice>,
    /// Body of the characters: capsules, mannequin, or the .glb file of a character with a skin, which all wear.
    #[arg(long, value_name = "BODY", value_parser = parse::body)]
    pub body: Option<BodyChoice>,

    /// What is shown of a bundle.
    #[arg(long, value_enum, requires = "file")]
    pub stage: Option<ViewStage>,
    /// Show a clip of the bundle: its name, or a part that no other name has.
    #[arg(long, value_name = "NAME", requires = "file")]
    pub clip: Option<String>,
    /// Stop the clip at a frame of it.
    #[arg(
        long,
        value_name = "N",
        requires = "file",
        allow_negative_numbers = true,
        value_parser = number_parser::<u32>(&limits::SHOWN_FRAME)
    )]
    pub frame: Option<u32>,
    /// Select a character, counted from 0.
    #[arg(
        long,
        value_name = "N",
        requires = "file",
        allow_negative_numbers = true,
        value_parser = number_parser::<usize>(&limits::FOLLOWED)
    )]
    pub character: Option<usize>,
    /// Number of characters of the crowd, scene or world.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number_parser::<usize>(&limits::SHOWN_CHARACTERS))]
    pub characters: Option<usize>,
    /// Seed of places, targets and choices.
    #[arg(long, allow_negative_numbers = true, value_parser = number_parser::<u64>(&limits::SEED))]
    pub seed: Option<u64>,
    /// Show how a message of a scene spreads: the name of one of its events.
    #[arg(long, value_name = "NAME", requires = "file")]
    pub message: Option<String>,
    /// What finds out when an agent of a scene has to act: events or occupancy.
    #[arg(long, value_name = "NAME", value_parser = parse::engine, requires = "file")]
    pub engine: Option<Scheme>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::BodyStyle;
    use clap::Parser;
    use clap::error::ErrorKind;

    fn parse(line: &str) -> Result<Args, clap::Error> {
        Args::try_parse_from(std::iter::once("throng-viewer").chain(line.split_whitespace()))
    }

    #[test]
    fn the_command_is_well_formed() {
        use clap::CommandFactory;
        Args::command().debug_assert();
    }

    #[test]
    fn a_full_line_is_understood() {
        let args = parse(
            "a.throng --png a.png --size 640x400 --frames 3 --camera front --panel control,statistics --theme light \
             --characters 7 --seed 9 --body capsules --character 2 --json --adapter any --scale 1.5",
        )
        .expect("a right line");
        assert_eq!(args.size, Some(PictureSize { width: 640, height: 400 }));
        assert_eq!((args.frames, args.characters, args.seed), (Some(3), Some(7), Some(9)));
        assert_eq!((args.panel.len(), args.character), (2, Some(2)));
        assert_eq!((args.adapter, args.scale), (AdapterChoice::Any, Some(1.5)));
        assert_eq!(args.body, Some(BodyChoice::Made(BodyStyle::Capsules)));
        assert_eq!(parse("--body me.GLB").expect("a right line").body, Some(BodyChoice::File("me.GLB".into())));
        assert_eq!(parse("a.toml --engine occupancy").expect("a right line").engine, Some(Scheme::Occupancy));
    }

    #[test]
    fn wrong_usage_is_named() {
        for (line, kind, say) in [
            ("a.throng --json", ErrorKind::MissingRequiredArgument, "--png"),
            ("a.throng --adapter any", ErrorKind::MissingRequiredArgument, "--png"),
            ("a.throng --characters 100001", ErrorKind::ValueValidation, limits::SHOWN_CHARACTERS.range),
            ("a.throng --seed -1", ErrorKind::ValueValidation, limits::SEED.range),
            ("a.throng --frames 0", ErrorKind::ValueValidation, limits::FRAMES.range),
            ("a.throng --frame 4294967296", ErrorKind::ValueValidation, limits::SHOWN_FRAME.range),
            ("a.throng --character -1", ErrorKind::ValueValidation, limits::FOLLOWED.range),
            ("a.throng --scale NaN", ErrorKind::ValueValidation, limits::SCALE.range),
            ("a.throng --size 640", ErrorKind::ValueValidation, "640x400"),
            ("a.throng --size 0x5", ErrorKind::ValueValidation, "8192"),
            ("a.throng --panel kitchen", ErrorKind::ValueValidation, "control"),
            ("a.throng --camera up", ErrorKind::ValueValidation, "three-quarter"),
            ("a.throng --body cube", ErrorKind::ValueValidation, "mannequin"),
            ("a.throng --scale 9", ErrorKind::ValueValidation, "0.5 to 3"),
            ("a.throng --character x", ErrorKind::ValueValidation, limits::FOLLOWED.range),
            ("a.toml --engine steam", ErrorKind::ValueValidation, "occupancy"),
        ] {
            let e = parse(line).expect_err(line);
            assert_eq!(e.kind(), kind, "{line}: {e}");
            assert!(e.to_string().contains(say), "{line}: {e}");
        }
    }
}
