//! A scene of a crowd that acts at its own events, with the bundle of its bodies where it names one.

use super::Bundle;
use crate::render::SolidMesh;
use crate::run::members::CrowdRun;
use crate::stage::members::meshes;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use throng_precompute::files::write_atomically;
use throng_precompute::scene::crowd::{CrowdScene, Engine};

/// Most members that a run may be begun with from the viewer.
pub const MAX_MEMBERS: usize = 100_000;
/// First line of a file with a snapshot.
const MAGIC: &str = "throng crowd snapshot 1";

/// What of a scene can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrowdChoice {
    /// What finds out when somebody has to act.
    pub engine: Engine,
    /// Number of members.
    pub members: usize,
    /// Seed of places and variety.
    pub seed: u64,
}

/// A run that is made on a thread of its own.
#[derive(Debug)]
struct Beginning {
    choice: CrowdChoice,
    made: Receiver<Result<CrowdRun, String>>,
}

/// A scene of a crowd that is open.
#[derive(Debug)]
pub struct CrowdDocument {
    path: PathBuf,
    scene: CrowdScene,
    /// That of the bodies.
    bundle: Option<Arc<Bundle>>,
    choice: CrowdChoice,
    run: CrowdRun,
    meshes: Arc<[SolidMesh]>,
    beginning: Option<Beginning>,
    /// Grows with every run.
    runs: u64,
}

impl CrowdDocument {
    /// True for a file that is a scene of a crowd.
    pub fn is_one(path: &Path) -> bool {
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) && CrowdScene::is_one(path)
    }

    /// Reads a scene and puts everybody where they start; where the bundle of its bodies is not there, as discs.
    ///
    /// # Errors
    /// A message that names the file and key, the impossible start, or what is wrong with the bundle, and the way out.
    pub fn open(path: &Path) -> Result<Self, String> {
        let scene = CrowdScene::load(path).map_err(|e| e.to_string())?;
        let choice = CrowdChoice { engine: scene.engine, members: scene.num_members(), seed: scene.seed };
        let named = scene.bodies.as_ref().map(|b| b.bundle.as_path()).filter(|b| b.exists());
        let bundle = named.map(Bundle::open).transpose();
        let bundle = bundle.map_err(|e| format!("{}: its bundle: {e}", path.display()))?.map(Arc::new);
        let run = CrowdRun::new(&scene, None, bundle.clone()).map_err(|e| format!("{}: {e}", path.display()))?;
        let meshes = meshes(run.cast());
        Ok(Self { path: path.to_path_buf(), scene, bundle, choice, run, meshes, beginning: None, runs: 0 })
    }

    /// The bundle of the bodies; none where members are discs or balls.
    pub fn bundle(&self) -> Option<&Bundle> {
        self.bundle.as_deref()
    }

    /// Why members are discs though the scene names bodies, and the way out.
    pub fn lacks(&self) -> Option<String> {
        let bodies = self.scene.bodies.as_ref().filter(|_| self.bundle.is_none())?;
        let (file, bundle) = (self.path.display(), bodies.bundle.display());
        let way_out = match &bodies.config {
            Some(config) => format!("`throng build {} --out {bundle}` makes it", config.display()),
            None => "build it, or correct the key `bodies.bundle`".into(),
        };
        Some(format!("{file}: everybody is a disc, for the bundle of the bodies {bundle} is not there; {way_out}"))
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it says.
    pub fn scene(&self) -> &CrowdScene {
        &self.scene
    }

    /// What runs now.
    pub fn choice(&self) -> CrowdChoice {
        self.choice
    }

    /// What is being made, and will run then.
    pub fn beginning(&self) -> Option<CrowdChoice> {
        self.beginning.as_ref().map(|b| b.choice)
    }

    /// Everybody now and before.
    pub fn run(&self) -> &CrowdRun {
        &self.run
    }

    /// The same, to be played, stopped and rewound.
    pub fn run_mut(&mut self) -> &mut CrowdRun {
        &mut self.run
    }

    /// Meshes of what stands.
    pub fn meshes(&self) -> &Arc<[SolidMesh]> {
        &self.meshes
    }

    /// Number of the run: another one where the crowd was begun anew.
    pub fn num_runs(&self) -> u64 {
        self.runs
    }

    /// Begins anew, on a thread of its own; [`CrowdDocument::take_in`] takes the run in when it is made. A new request
    /// replaces an old one.
    ///
    /// - `kept`: a state to go on from.
    /// - `wake`: called when it is made.
    ///
    /// # Errors
    /// A message where numbers are out of range; nothing has changed then.
    pub fn begin(
        &mut self,
        choice: CrowdChoice,
        kept: Option<Vec<u8>>,
        wake: impl FnOnce() + Send + 'static,
    ) -> Result<(), String> {
        if !(1..=MAX_MEMBERS).contains(&choice.members) {
            return Err(format!("expected 1 to {MAX_MEMBERS} members, found {}", choice.members));
        }
        let mut scene = match choice.members == self.scene.num_members() {
            true => self.scene.clone(),
            false => self.scene.resized(choice.members),
        };
        (scene.engine, scene.seed) = (choice.engine, choice.seed);
        scene.check(&self.path).map_err(|e| e.to_string())?;
        let (send, made) = channel();
        self.beginning = Some(Beginning { choice, made });
        let bundle = self.bundle.clone();
        std::thread::spawn(move || {
            let run = CrowdRun::new(&scene, kept.as_deref(), bundle).map_err(|e| e.to_string());
            // Nobody listens where another one was asked for meanwhile.
            if send.send(run).is_ok() {
                wake();
            }
        });
        Ok(())
    }

    /// Takes in a run that has been made since the last call; true where one has.
    ///
    /// - `waits`: until it is made, where one is being made.
    ///
    /// # Errors
    /// A message where it could not be made; the old one goes on.
    pub fn take_in(&mut self, waits: bool) -> Result<bool, String> {
        let Some(b) = &self.beginning else { return Ok(false) };
        let made = match waits {
            true => b.made.recv().map_err(|_| TryRecvError::Disconnected),
            false => b.made.try_recv(),
        };
        let made = match made {
            Err(TryRecvError::Empty) => return Ok(false),
            Err(TryRecvError::Disconnected) => Err("beginning anew failed unexpectedly".to_owned()),
            Ok(made) => made,
        };
        let choice = b.choice;
        self.beginning = None;
        let run = made?;
        let old = std::mem::replace(&mut self.run, run);
        self.run.reel.head.play_like(&old.reel.head);
        self.meshes = meshes(self.run.cast());
        (self.choice, self.runs) = (choice, self.runs + 1);
        Ok(true)
    }

    /// Writes the state of the run.
    ///
    /// # Errors
    /// A message that names the file and the reason.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let choice = serde_json::to_string(&self.choice).map_err(|e| e.to_string())?;
        let state = self.run.snapshot();
        write_atomically(path, |out| {
            writeln!(out, "{MAGIC}\n{choice}")?;
            out.write_all(&state)
        })
        .map_err(|e| e.to_string())
    }

    /// Goes on from a state that was written; as [`CrowdDocument::begin`].
    ///
    /// # Errors
    /// A message that names the file and what is wrong with it.
    pub fn restore(&mut self, path: &Path, wake: impl FnOnce() + Send + 'static) -> Result<(), String> {
        let name = path.display();
        let bytes = std::fs::read(path).map_err(|e| format!("{name}: {e}"))?;
        let mut parts = bytes.splitn(3, |&b| b == b'\n');
        let (magic, choice, state) = (parts.next(), parts.next(), parts.next());
        let wrong = || format!("{name}: this is no snapshot of a crowd; the panel Crowd writes some (Save)");
        let (Some(choice), Some(state)) = (choice.filter(|_| magic == Some(MAGIC.as_bytes())), state) else {
            return Err(wrong());
        };
        let choice = serde_json::from_slice(choice).map_err(|_| wrong())?;
        self.begin(choice, Some(state.to_vec()), wake).map_err(|e| format!("{name}: {e}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panels::tests::meeting::Meeting;
    use crate::panels::tests::paces::Paces;

    fn step(document: &mut CrowdDocument, steps: u32) {
        document.run_mut().want(steps);
        document.run_mut().advance(0.0, None).unwrap();
    }

    #[test]
    fn a_scene_is_begun_anew_with_other_numbers() {
        let meeting = Meeting::new();
        let mut document = CrowdDocument::open(&meeting.scene(12)).unwrap();
        assert!(CrowdDocument::is_one(document.path()));
        let choice = CrowdChoice { members: 8, seed: 5, ..document.choice() };
        document.begin(choice, None, || {}).unwrap();
        assert_eq!((document.beginning(), document.run().cast().groups.len()), (Some(choice), 24));
        assert!(document.take_in(true).unwrap());
        assert_eq!((document.beginning(), document.run().cast().groups.len()), (None, 8));
        assert_eq!((document.choice(), document.num_runs()), (choice, 1));
        for members in [0, MAX_MEMBERS + 1] {
            let e = document.begin(CrowdChoice { members, ..choice }, None, || {}).unwrap_err();
            assert!(e.contains("1 to 100000"), "{e}");
        }
    }

    #[test]
    fn a_state_that_was_written_goes_on_as_it_did() {
        let meeting = Meeting::new();
        let mut document = CrowdDocument::open(&meeting.scene(12)).unwrap();
        let file = meeting.folder().join("a.crowd");
        step(&mut document, 90);
        document.save(&file).unwrap();
        step(&mut document, 60);
        let (hash, time_s) = (document.run().state_hash(), document.run().moment().time_s);
        document.begin(CrowdChoice { members: 8, ..document.choice() }, None, || {}).unwrap();
        document.take_in(true).unwrap();
        document.restore(&file, || {}).unwrap();
        assert!(document.take_in(true).unwrap());
        assert_eq!((document.choice().members, document.run().moment().time_s), (24, 1.5));
        step(&mut document, 60);
        assert!((document.run().moment().time_s - time_s).abs() < 1e-9);
        assert_eq!(document.run().state_hash(), hash);
        std::fs::write(&file, "something else").unwrap();
        let e = document.restore(&file, || {}).unwrap_err();
        assert!(e.contains("a.crowd") && e.contains("no snapshot"), "{e}");
    }

    #[test]
    fn without_the_bundle_of_its_bodies_everybody_is_a_disc() {
        let paces = Paces::new();
        let path = paces.crowd(2);
        let document = CrowdDocument::open(&path).unwrap();
        assert!(document.bundle().is_some() && document.lacks().is_none());
        assert!(document.run().moment().bodies.is_some());
        std::fs::rename(paces.bundle(), paces.folder().join("elsewhere.throng")).unwrap();
        let document = CrowdDocument::open(&path).unwrap();
        assert!(document.bundle().is_none() && document.run().moment().bodies.is_none());
        let why = document.lacks().unwrap();
        assert!(why.contains("people.toml") && why.contains("throng build") && why.contains("paces.toml"), "{why}");
        std::fs::write(paces.bundle(), "no bundle").unwrap();
        let e = CrowdDocument::open(&path).map(|_| ()).unwrap_err();
        assert!(e.contains("people.toml") && e.contains("paces.throng"), "{e}");
    }

    #[test]
    fn what_is_impossible_is_named() {
        let meeting = Meeting::new();
        let path = meeting.scene(12);
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to, say) in [("count = 12", "count = 0", "count"), ("[-9.0, -3.0]", "[-2.2, -3.0]", "overlap")] {
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let e = CrowdDocument::open(&path).map(|_| ()).unwrap_err();
            assert!(e.contains("meeting") && e.contains(say), "{e}");
        }
    }
}
