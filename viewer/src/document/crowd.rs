//! A scene of a crowd that acts at its own events, with the bundle of its bodies where it names one.

use super::obstacles::meshes;
use crate::bundle::OpenBundle;
use crate::render::SolidMesh;
use crate::run::agents::CrowdRun;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use throng_precompute::files::write_atomically;
use throng_precompute::progress::Progress;
use throng_precompute::scene::crowd::{CrowdScene, Engine};

/// Most agents that a run may be begun with from the viewer.
pub const MAX_MEMBERS: usize = 100_000;
/// First line of a file with a snapshot.
const MAGIC: &str = "throng crowd snapshot 1";

/// What of a scene can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrowdChoice {
    /// The engine that schedules events.
    pub engine: Engine,
    /// Number of agents.
    pub agents: usize,
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
    bundle: Option<Arc<OpenBundle>>,
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

    /// Reads a scene and puts all agents at their starts; builds the bundle of its bodies where that is missing.
    ///
    /// # Errors
    /// A message that names the file and key, the impossible start, or what is wrong with the bundle, and the way out.
    pub fn open(path: &Path, progress: &dyn Progress) -> Result<Self, String> {
        let scene = CrowdScene::load(path).map_err(|e| e.to_string())?;
        let choice = CrowdChoice { engine: scene.engine, agents: scene.num_agents(), seed: scene.seed };
        let of_bodies = scene.bodies.as_ref();
        let bundle =
            of_bodies.map(|b| OpenBundle::open_or_build(path, &b.bundle, b.config.as_deref(), progress)).transpose()?;
        let bundle = bundle.map(Arc::new);
        let run = CrowdRun::new(&scene, None, bundle.clone()).map_err(|e| format!("{}: {e}", path.display()))?;
        let meshes = meshes(run.cast());
        Ok(Self { path: path.to_path_buf(), scene, bundle, choice, run, meshes, beginning: None, runs: 0 })
    }

    /// The bundle of the bodies; none if agents are discs or balls.
    pub fn bundle(&self) -> Option<&OpenBundle> {
        self.bundle.as_deref()
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

    /// The recorded run.
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

    /// Number of the run: it changes when the crowd restarts.
    pub fn num_runs(&self) -> u64 {
        self.runs
    }

    /// Restarts on a thread of its own; [`CrowdDocument::take_in`] takes the run in when it is made. A new request
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
        if !(1..=MAX_MEMBERS).contains(&choice.agents) {
            return Err(format!("expected 1 to {MAX_MEMBERS} agents, found {}", choice.agents));
        }
        let mut scene = match choice.agents == self.scene.num_agents() {
            true => self.scene.clone(),
            false => self.scene.resized(choice.agents),
        };
        (scene.engine, scene.seed) = (choice.engine, choice.seed);
        scene.check(&self.path).map_err(|e| e.to_string())?;
        let (send, made) = channel();
        self.beginning = Some(Beginning { choice, made });
        let bundle = self.bundle.clone();
        std::thread::spawn(move || {
            let run = CrowdRun::new(&scene, kept.as_deref(), bundle).map_err(|e| e.to_string());
            // The receiver is gone if another one was asked for meanwhile.
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
            Err(TryRecvError::Disconnected) => Err("restarting failed unexpectedly".to_owned()),
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
        let wrong = || format!("{name}: this is not a snapshot of a crowd; the panel Crowd saves them");
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
    use crate::fixtures::meeting::Meeting;
    use crate::fixtures::paces::Paces;
    use throng_precompute::progress::Silent;

    fn step(document: &mut CrowdDocument, steps: u32) {
        document.run_mut().want(steps);
        document.run_mut().advance(0.0, None).unwrap();
    }

    #[test]
    fn a_scene_restarts_with_other_numbers() {
        let meeting = Meeting::new();
        let mut document = CrowdDocument::open(&meeting.scene(12), &Silent).unwrap();
        assert!(CrowdDocument::is_one(document.path()));
        let choice = CrowdChoice { agents: 8, seed: 5, ..document.choice() };
        document.begin(choice, None, || {}).unwrap();
        assert_eq!((document.beginning(), document.run().cast().groups.len()), (Some(choice), 24));
        assert!(document.take_in(true).unwrap());
        assert_eq!((document.beginning(), document.run().cast().groups.len()), (None, 8));
        assert_eq!((document.choice(), document.num_runs()), (choice, 1));
        for agents in [0, MAX_MEMBERS + 1] {
            let e = document.begin(CrowdChoice { agents, ..choice }, None, || {}).unwrap_err();
            assert!(e.contains("1 to 100000"), "{e}");
        }
    }

    #[test]
    fn a_restored_state_continues_as_before() {
        let meeting = Meeting::new();
        let mut document = CrowdDocument::open(&meeting.scene(12), &Silent).unwrap();
        let file = meeting.folder().join("a.crowd");
        step(&mut document, 90);
        document.save(&file).unwrap();
        step(&mut document, 60);
        let (hash, time_s) = (document.run().state_hash(), document.run().moment().time_s);
        document.begin(CrowdChoice { agents: 8, ..document.choice() }, None, || {}).unwrap();
        document.take_in(true).unwrap();
        document.restore(&file, || {}).unwrap();
        assert!(document.take_in(true).unwrap());
        assert_eq!((document.choice().agents, document.run().moment().time_s), (24, 1.5));
        step(&mut document, 60);
        assert!((document.run().moment().time_s - time_s).abs() < 1e-9);
        assert_eq!(document.run().state_hash(), hash);
        std::fs::write(&file, "something else").unwrap();
        let e = document.restore(&file, || {}).unwrap_err();
        assert!(e.contains("a.crowd") && e.contains("not a snapshot"), "{e}");
    }

    #[test]
    fn a_missing_bundle_of_bodies_is_built() {
        let paces = Paces::new();
        let path = paces.crowd(2);
        std::fs::remove_file(paces.bundle()).unwrap();
        let document = CrowdDocument::open(&path, &Silent).unwrap();
        assert!(paces.bundle().exists() && document.run().moment().bodies.is_some());
        std::fs::write(paces.bundle(), "no bundle").unwrap();
        let e = CrowdDocument::open(&path, &Silent).map(|_| ()).unwrap_err();
        assert!(e.contains("people.toml") && e.contains("paces.throng"), "{e}");
        std::fs::remove_file(paces.bundle()).unwrap();
        std::fs::remove_file(paces.folder().join("paces.toml")).unwrap();
        let e = CrowdDocument::open(&path, &Silent).map(|_| ()).unwrap_err();
        assert!(e.contains("people.toml") && e.contains("paces.throng") && e.contains("paces.toml"), "{e}");
    }

    #[test]
    fn impossible_scenes_are_refused_by_name() {
        let meeting = Meeting::new();
        let path = meeting.scene(12);
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to, say) in [("count = 12", "count = 0", "count"), ("[-9.0, -3.0]", "[-2.2, -3.0]", "overlap")] {
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let e = CrowdDocument::open(&path, &Silent).map(|_| ()).unwrap_err();
            assert!(e.contains("meeting") && e.contains(say), "{e}");
        }
    }
}
