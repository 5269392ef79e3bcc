//! Blend spaces in a bundle: they come back as they were written, and what cannot be is refused.

use super::made_up::{SIX, config, set, six};
use super::parts::{Change, Parts};
use glam::Vec2;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;
use throng_core::blend::{BlendRecord, ChannelRow, ExampleRecord, ReferenceRow, channel};
use throng_core::bundle::tags;
use throng_core::format::{AlignedBytes, Meta, SectionTag};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{Bundle, CharacterGroup, Id, Inline};
use throng_precompute::examples::{self, BlendReport, BlendSpaces};
use throng_precompute::graph::RawMotionGraph;
use throng_precompute::inspect::BundleReport;
use throng_precompute::picture::blend_sheet;
use throng_precompute::progress::Silent;
use throng_precompute::stops::StopRows;
use throng_precompute::write::{self, BundleInputs};
use throng_simulation::Scene;

fn spaces() -> BlendSpaces {
    let line = "axes = [{ kind = 'speed', range = [0.0, 2.0] }]\nexamples = [{ clip = 'slow' }, { clip = 'fast' }]\nphases = 8";
    let configs = BTreeMap::from([("plane".to_owned(), config(SIX)), ("line".to_owned(), config(line))]);
    examples::fit(&set(six()), &configs, &Silent).expect("two spaces")
}

/// A bundle of the two spaces and no motion graph.
fn bundle() -> &'static [u8] {
    static BUNDLE: OnceLock<Vec<u8>> = OnceLock::new();
    BUNDLE.get_or_init(|| bundle_of(&spaces()))
}

fn bundle_of(spaces: &BlendSpaces) -> Vec<u8> {
    let (clips, graph) = (set(six()), RawMotionGraph::default());
    let meta = Meta { rate_hz: 60.0, ..Meta::default() };
    let baked = BundleInputs {
        clips: &clips,
        graph: &graph,
        stops: &StopRows::default(),
        policies: &[],
        groups: None,
        patches: None,
        blends: &spaces.spaces,
        activities: &[],
        meta: &meta,
    };
    let mut bytes = Vec::new();
    write::lay_out(&baked).expect("sections").write(&mut bytes).expect("memory takes all bytes");
    bytes
}

fn open(bytes: &[u8]) -> Bundle {
    Bundle::from_bytes(AlignedBytes::from_slice(bytes)).expect("the bundle opens")
}

#[test]
fn walkers_adopt_the_space_of_the_same_name() {
    let tables = open(bundle());
    let mut walkers = Walkers::with_capacity(tables.blend("plane").unwrap(), &[], WalkersConfig::default(), 3).unwrap();
    let ids: Vec<Id> = (0..2).map(|_| walkers.spawn(WalkerStart::default()).unwrap()).collect();
    walkers.order(ids[1], Control::walk(Vec2::Y)).unwrap();
    (0..60).for_each(|_| walkers.step(1.0 / 60.0, &Inline).unwrap());
    let (hash, root) = (walkers.hash(), walkers.root(1));
    let mut bytes = Vec::new();
    walkers.save(&mut bytes);

    let adopted = walkers.adopt(&tables).unwrap();
    assert_eq!((adopted.num_characters, walkers.hash()), (2, hash), "nothing differs");
    assert!(adopted.farthest_m < 0.02, "{adopted:?}");

    let line = open(&bundle_of(&BlendSpaces { spaces: spaces().spaces.into_iter().take(1).collect(), ..spaces() }));
    let e = walkers.adopt(&line).expect_err("no such space").to_string();
    assert!(e.contains("\"plane\"; there is line"), "{e}");
    assert_eq!((walkers.hash(), walkers.root(1)), (hash, root));

    // Only one axis, and fewer examples.
    let mut other = spaces().spaces.remove(0);
    other.name = "plane".into();
    let other = open(&bundle_of(&BlendSpaces { spaces: vec![other], ..spaces() }));
    assert_eq!(walkers.adopt(&other).unwrap().num_characters, 2);
    assert!(walkers.load(&bytes).is_err(), "taken with another bundle");
    (0..60).for_each(|_| walkers.step(1.0 / 60.0, &Inline).unwrap());
    assert!((walkers.root(1).z - root.z - 1.0).abs() < 1e-3 && walkers.weights(1).len() == 2);
    assert!(walkers.joint_positions(1).iter().all(|p| p.is_finite()));
}

#[test]
fn spaces_come_back_as_they_were_written() {
    let tables = Bundle::from_bytes(AlignedBytes::from_slice(bundle())).expect("the bundle opens");
    let (blends, made) = (tables.blends(), spaces().spaces);
    assert_eq!(tables.meta().blends.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), ["line", "plane"]);
    assert_eq!(tables.find_blend("plane").unwrap(), 1);
    let told = BundleReport::new(Path::new("a.throng"), &tables).expect("a report").to_string();
    // The soles of these made-up clips slide along.
    assert!(told.contains("blends   line: usable (planted soles slip "), "{told}");
    assert!(told.contains("); 2 examples of fast, slow\n"), "{told}");
    assert!(told.contains("blends   plane: ") && told.contains("6 examples of fast, fast_left,"), "{told}");
    let report = &BlendReport::of_bundle(&tables).expect("reports")[1];
    assert_eq!(report.quality, spaces().report[1].quality, "the same tables are judged alike");
    assert_eq!(report.examples.len(), 6);
    let picture = blend_sheet(&tables).expect("a picture");
    let ink = (0..picture.width()).filter(|x| picture.pixel(*x, 130) != picture.pixel(0, 130)).count();
    assert!(picture.height() > 400 && ink > 100, "two rows of figures: {} x {}", picture.width(), picture.height());
    assert_eq!(tables.meta().blends[1].axes, ["speed", "gyration"]);
    for (space, made) in blends.spaces.iter().zip(&made) {
        let part = |first: u32, n: usize| first as usize..first as usize + n;
        assert_eq!(blends.examples[part(space.first_example, made.examples.len())], made.examples[..]);
        assert_eq!(blends.weights[part(space.first_weight, made.weights.len())], made.weights[..]);
        assert_eq!(blends.references[part(space.first_row, made.references.len())], made.references[..]);
        assert_eq!(blends.channels[part(space.first_channel_row, made.channels.len())], made.channels[..]);
    }
}

#[test]
fn scenes_name_the_space_that_is_missing_before_anybody_walks() {
    let tables = Bundle::from_bytes(AlignedBytes::from_slice(bundle())).expect("the bundle opens");
    for (spaces, shown, key, name) in
        [("plane", "lime", "picture.shown[0].space", "lime"), ("plan", "line", "groups[0].spaces[0]", "plan")]
    {
        let text = format!(
            "bundle = 'a.throng'\n[[groups]]\nmotion = 'blend'\ncount = 1\nspaces = ['{spaces}']\npaths = {{}}\n\
             [[picture.shown]]\nname = 'a'\nspace = '{shown}'\nspeed = 1.0\n"
        );
        let scene = Scene::parse(&text, Path::new("a.toml")).expect("a scene");
        let e = scene.compile(&tables).map(|_| ()).expect_err("no such space").to_string();
        assert!(e.contains(&format!("key `{key}`")) && e.contains(&format!("\"{name}\"; there is line, plane")), "{e}");
    }
}

#[test]
fn the_same_clips_give_the_same_spaces_at_any_number_of_threads() {
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(spaces);
    assert_eq!(on(1), on(8));
}

fn refuses(tag: Option<SectionTag>, changes: &[Change<'_>]) {
    super::parts::refuses(bundle(), tag, changes);
}

const BAD: [f32; 4] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e9];

#[test]
fn records_of_spaces_that_cannot_be_are_refused() {
    let record =
        |p: &mut Parts, f: &dyn Fn(&mut BlendRecord)| p.edit::<BlendRecord>(tags::BLENDS, |all| f(&mut all[1]));
    refuses(
        Some(tags::BLENDS),
        &[
            ("no axes", &|p| record(p, &|r| r.num_axes = 0)),
            ("too many axes", &|p| record(p, &|r| r.num_axes = 7)),
            ("an axis less than is filled in", &|p| record(p, &|r| r.num_axes = 1)),
            ("an unknown kind", &|p| record(p, &|r| r.axes[0].kind = 4)),
            ("one knot", &|p| record(p, &|r| r.axes[1].num_knots = 1)),
            ("another number of knots", &|p| record(p, &|r| r.axes[1].num_knots += 1)),
            ("countless knots", &|p| record(p, &|r| r.axes[1].num_knots = u32::MAX)),
            ("a box inside out", &|p| record(p, &|r| r.axes[0].low = r.axes[0].high)),
            ("no box", &|p| record(p, &|r| r.axes[0].high = f32::NAN)),
            ("another row length", &|p| record(p, &|r| r.weight_stride = 16)),
            ("examples that overlap", &|p| record(p, &|r| r.first_example = 0)),
            ("weights that overlap", &|p| record(p, &|r| r.first_weight = 0)),
            ("rows that overlap", &|p| record(p, &|r| r.first_row = 0)),
            ("channels past the end", &|p| record(p, &|r| r.first_channel_row = u32::MAX)),
            ("phases past the end", &|p| record(p, &|r| r.num_phases += 1)),
            ("one phase", &|p| record(p, &|r| r.num_phases = 1)),
            ("half extrapolated", &|p| record(p, &|r| r.extrapolate = 2)),
            ("a negative error", &|p| record(p, &|r| r.max_weight_error = -1.0)),
        ],
    );
    let meta = |p: &mut Parts, f: &dyn Fn(&mut Meta)| p.edit_meta(f);
    refuses(
        None,
        &[
            ("a space too many", &|p| meta(p, &|m| m.blends.push(Default::default()))),
            ("one name for both", &|p| meta(p, &|m| m.blends[1].name = m.blends[0].name.clone())),
            ("an axis without a name", &|p| meta(p, &|m| m.blends[0].axes.clear())),
            ("an example without a name", &|p| meta(p, &|m| m.blends[0].examples.truncate(1))),
            ("weights too many", &|p| p.edit::<f32>(tags::BLEND_WEIGHTS, |w| w.extend([0.0; 8]))),
            ("no space, but its rows", &|p| {
                p.edit::<BlendRecord>(tags::BLENDS, |b| b.truncate(1));
                meta(p, &|m| m.blends.truncate(1));
            }),
        ],
    );
}

#[test]
fn examples_that_cannot_be_are_refused() {
    let num_clips = six().len() as u32;
    let example = |p: &mut Parts, f: &dyn Fn(&mut ExampleRecord)| {
        p.edit::<ExampleRecord>(tags::BLEND_EXAMPLES, |all| f(&mut all[3]));
    };
    refuses(
        Some(tags::BLEND_EXAMPLES),
        &[
            ("clip after the last", &|p| example(p, &|e| e.clip = num_clips)),
            ("frames after the last", &|p| example(p, &|e| e.first_frame = 10_000)),
            ("countless frames", &|p| example(p, &|e| e.num_frames = u32::MAX)),
            ("no frames", &|p| example(p, &|e| e.num_frames = 0)),
            ("no time", &|p| example(p, &|e| e.duration_s = 0.0)),
            ("an unknown flag", &|p| example(p, &|e| e.flags = 4)),
            ("still, but with steps", &|p| example(p, &|e| e.flags = ExampleRecord::IS_STILL)),
            ("a keytime past the cycle", &|p| example(p, &|e| e.keytimes[2] = 1.0)),
            ("a parameter on no axis", &|p| example(p, &|e| e.parameters[2] = 1.0)),
            ("reserved field", &|p| example(p, &|e| e.reserved = 1)),
        ],
    );
    for bad in BAD {
        refuses(
            Some(tags::BLEND_EXAMPLES),
            &[
                ("parameter", &|p| example(p, &|e| e.parameters[0] = bad)),
                ("velocity", &|p| example(p, &|e| e.velocity[1] = bad)),
                ("gyration", &|p| example(p, &|e| e.gyration = bad)),
                ("duration", &|p| example(p, &|e| e.duration_s = bad)),
                ("keytime", &|p| example(p, &|e| e.keytimes[0] = bad)),
            ],
        );
    }
}

#[test]
fn rows_that_cannot_be_are_refused() {
    let weight = |p: &mut Parts, at: usize, to: f32| p.edit::<f32>(tags::BLEND_WEIGHTS, |w| w[at] = to);
    let reference = |p: &mut Parts, f: &dyn Fn(&mut [[f32; 24]; 4])| {
        p.edit::<ReferenceRow>(tags::BLEND_REFERENCES, |all| f(&mut all[9].components));
    };
    let value = |p: &mut Parts, at: usize, to: f32| {
        p.edit::<ChannelRow>(tags::BLEND_CHANNELS, |all| all[30].values[at] = to);
    };
    for bad in BAD {
        refuses(Some(tags::BLEND_WEIGHTS), &[("weight", &|p| weight(p, 1, bad))]);
        refuses(Some(tags::BLEND_REFERENCES), &[("reference", &|p| reference(p, &|c| c[1][4] = bad))]);
        for at in [0, 50, channel::HIPS, channel::RATE, channel::LEFT_CONTACT, channel::GYRATION] {
            refuses(Some(tags::BLEND_CHANNELS), &[("channel", &|p| value(p, at, bad))]);
        }
    }
    refuses(
        Some(tags::BLEND_WEIGHTS),
        &[
            ("a weight row that sums to more than one", &|p| weight(p, 0, 5.0)),
            ("a weight of no example", &|p| weight(p, 7, 0.5)),
        ],
    );
    refuses(
        Some(tags::BLEND_REFERENCES),
        &[
            ("no rotation", &|p| reference(p, &|c| (0..4).for_each(|k| c[k][2] = 0.0))),
            ("on the other side", &|p| reference(p, &|c| (0..4).for_each(|k| c[k][2] = -c[k][2]))),
            ("a rotation of no joint", &|p| reference(p, &|c| (c[0][23], c[3][23]) = (1.0, 0.0))),
        ],
    );
    refuses(
        Some(tags::BLEND_CHANNELS),
        &[
            ("time that stands", &|p| value(p, channel::RATE, 0.0)),
            ("more than contact", &|p| value(p, channel::RIGHT_CONTACT, 1.5)),
            ("a displacement of no joint", &|p| value(p, 23, 0.1)),
            ("a channel too many", &|p| value(p, 95, 1.0)),
        ],
    );
}
