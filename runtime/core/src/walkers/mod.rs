//! Walkers: many characters on free trajectories, whose bodies come from a blend space.

mod block;
mod character_group;
mod config;
mod perform;
mod steer;
mod step;

use crate::body::{
    BodyEvents, Detail, DetailLevel, LaneBody, LocalTransform, Mat3x4, PoseInstance, RANGE_BLOCKS, RANGE_LEN,
};
use crate::body::{HeightField, find_soles};
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use crate::{blend::BlendSpace, blend::MAX_AXES};
use crate::{contacts::Contacts, planar::Planar, roster::Roster};
use block::WalkerBlock;
pub use config::{Control, InertiaConfig, WalkerStart, WalkersConfig};
use glam::Vec3;
use perform::PerformanceState;
pub use perform::{Performance, PerformancePart, PerformanceProgress};
use serde::{Deserialize, Serialize};
use step::{WalkerRange, WalkersTick};
use throng_base::{Executor, Hash128, Id, Result, limits::CAPACITY, maths, run_each, simd::LANES};

/// Characters that follow trajectories with blended bodies, eight to a block. A [`CharacterGroup`](crate::CharacterGroup): they enter and
/// leave, and are ordered about with [`Control`].
///
/// Every step moves each walker along its trajectory, turns it, finds the weights of the examples for its speed, turning
/// rate and style, advances generic time, blends a posture, and retargets it to the walker's body: the hips keep the
/// elevation and sway of the examples, planted feet stay where they are, and legs and touching arms reach by analytic
/// inverse kinematics (Kim, Kim and Shin 2003a, section 4.2).
///
/// Walkers are numbered by row, as in [`CharacterGroup::bodies`](crate::CharacterGroup::bodies): in the order in which they entered, but the
/// last one takes the row of one that leaves.
///
/// ```no_run
/// use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
/// use throng_core::{Bundle, CharacterGroup, Inline, glam::Vec2};
///
/// let space = Bundle::open("people.throng")?.blend("walks")?;
/// let mut walkers = Walkers::with_capacity(space, &[], WalkersConfig::default(), 100)?;
/// let id = walkers.spawn(WalkerStart::default())?;
/// walkers.order(id, Control::walk(Vec2::new(0.0, 1.3)))?;
/// walkers.step(1.0 / 60.0, &Inline)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Walkers {
    space: BlendSpace,
    /// Bodies that a start chooses from.
    skeletons: Vec<Skeleton>,
    /// The bodies are that of the database alone.
    is_database_body: bool,
    ground: HeightField,
    config: WalkersConfig,
    /// Content hash of all of the above, and the capacity.
    setup: u128,
    state: WalkersState,
    bodies: Vec<LaneBody>,
    weights: Vec<f32>,
    roots: Vec<Planar>,
    model: Vec<[Mat3x4; NUM_JOINTS]>,
    locals: Vec<LocalTransform>,
    instances: Vec<PoseInstance>,
    detail: Option<Detail>,
    /// Level at which the last step computed each block.
    levels: Vec<DetailLevel>,
    events: BodyEvents,
    /// Weights of a block that is only posed.
    block_weights: Vec<f32>,
}

/// State on which the next steps depend, row by row.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct WalkersState {
    roster: Roster,
    /// Number of each body.
    bodies: Vec<u32>,
    orders: Vec<Control>,
    /// True for walkers that have had an order.
    ordered: Vec<bool>,
    acts: Vec<WalkerActivity>,
    blocks: Vec<WalkerBlock>,
}

/// Activity of a walker beside locomotion.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct WalkerActivity {
    acting: PerformanceState,
    /// True if its performance ended in the last step.
    has_ended: bool,
}

impl Walkers {
    /// Room for `capacity` walkers on flat ground; all memory is allocated here.
    ///
    /// - `bodies`: skeletons that [`WalkerStart::body`] chooses from, of any size and proportions, whose rest pose stands
    ///   on the ground; none stands for the skeleton of the examples.
    ///
    /// # Errors
    /// [`Error::Value`](throng_base::Error::Value) for a body, setting or capacity out of range.
    pub fn with_capacity(
        space: BlendSpace,
        bodies: &[Skeleton],
        config: WalkersConfig,
        capacity: usize,
    ) -> Result<Self> {
        config.check()?;
        CAPACITY.check_count("capacity", capacity)?;
        let is_database_body = bodies.is_empty();
        let skeletons = if is_database_body { vec![space.skeleton().clone()] } else { bodies.to_vec() };
        skeletons.iter().chain([space.skeleton()]).try_for_each(config::check_body)?;
        let (blocks, stride) = (capacity.div_ceil(LANES), space.stride());
        let locals = if config.local_transforms { capacity * NUM_JOINTS } else { 0 };
        let state = WalkersState {
            roster: Roster::with_capacity(capacity),
            bodies: Vec::with_capacity(capacity),
            orders: Vec::with_capacity(capacity),
            ordered: Vec::with_capacity(capacity),
            acts: Vec::with_capacity(capacity),
            blocks: Vec::with_capacity(blocks),
        };
        let mut walkers = Self {
            space,
            skeletons,
            is_database_body,
            ground: HeightField::flat(),
            config,
            setup: 0,
            state,
            bodies: Vec::with_capacity(blocks),
            weights: Vec::with_capacity(capacity * stride),
            roots: Vec::with_capacity(capacity),
            model: Vec::with_capacity(capacity),
            locals: Vec::with_capacity(locals),
            instances: Vec::with_capacity(if config.instances { capacity } else { 0 }),
            detail: None,
            levels: Vec::with_capacity(blocks),
            events: BodyEvents::with_capacity(capacity, 0),
            block_weights: vec![0.0; LANES * stride],
        };
        walkers.setup = walkers.find_setup(capacity);
        Ok(walkers)
    }

    /// Changes the ground that all stand on.
    pub fn set_ground(&mut self, ground: HeightField) {
        self.ground = ground;
        self.setup = self.find_setup(self.capacity());
    }

    /// The blend space.
    pub fn space(&self) -> &BlendSpace {
        &self.space
    }

    /// Most walkers.
    pub fn capacity(&self) -> usize {
        self.state.roster.capacity()
    }

    /// Number of walkers.
    pub fn len(&self) -> usize {
        self.state.roster.ids().len()
    }

    /// True without walkers.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The row of a walker.
    ///
    /// # Errors
    /// [`Error::Gone`](throng_base::Error::Gone).
    pub fn row(&self, id: Id) -> Result<usize> {
        self.state.roster.row(id)
    }

    /// Planar root: on the trajectory, with the heading of the body (row < len).
    pub fn root(&self, row: usize) -> Planar {
        self.roots[row]
    }

    /// Planted parts of the feet (row < len).
    pub fn contacts(&self, row: usize) -> Contacts {
        self.state.blocks[row / LANES].contacts[row % LANES]
    }

    /// Checks the numbers of an order, and that there is what its layers show.
    ///
    /// # Errors
    /// [`Error::Value`](throng_base::Error::Value), [`Error::Index`](throng_base::Error::Index).
    pub fn check_order(&self, id: Id, order: &Control) -> Result<()> {
        order.check(id, self.space.activities().rows.frames.len())
    }

    /// Begins, changes or ends a walker's activity beside locomotion.
    ///
    /// The walker comes to a stand, turns to the heading, and plays the activity; standing feet stay in place. Until
    /// the activity is over it keeps its heading, and its place where the order gives no position. The activity ends at
    /// its end; with `None` or another performance, which follows it; and when the order requests more than 0.3 m/s. A
    /// walker that sits stands up first: [`Walkers::performing`] shows until when to wait. [`BodyEventKind::Performed`](crate::body::BodyEventKind::Performed)
    /// reports the end.
    ///
    /// # Errors
    /// [`Error::Gone`](throng_base::Error::Gone), [`Error::Index`](throng_base::Error::Index) for an activity that is
    /// not in [`BlendSpace::activities`], [`Error::Value`](throng_base::Error::Value) for a heading that is no number.
    pub fn perform(&mut self, id: Id, performance: Option<Performance>) -> Result<()> {
        let row = self.row(id)?;
        performance.map_or(Ok(()), |p| p.check(self.space.activities()))?;
        let heading = self.root(row).heading;
        self.state.acts[row].acting.set_performance(performance, heading);
        Ok(())
    }

    /// Performance of a walker and its progress; none while it moves as blended, or is about to (row < len).
    pub fn performing(&self, row: usize) -> Option<PerformanceProgress> {
        self.state.acts[row].acting.performance_progress()
    }

    /// Displaces a part of a walker's body, which then comes back; see [`ReactionConfig`](crate::body::ReactionConfig).
    ///
    /// - `displacement`: in the world (m).
    ///
    /// # Errors
    /// [`Error::Gone`](throng_base::Error::Gone), or [`Error::Value`](throng_base::Error::Value) for a displacement that is
    /// not finite.
    pub fn push(&mut self, id: Id, joint: Joint, displacement: Vec3) -> Result<()> {
        let row = self.row(id)?;
        self.state.blocks[row / LANES].body.push(row % LANES, &self.config.reaction, Some(id), joint, displacement)
    }

    /// Generic time, in 0..1 (row < len).
    pub fn phase(&self, row: usize) -> f32 {
        self.state.blocks[row / LANES].phase[row % LANES]
    }

    /// Position in the parameter box, scaled to the database skeleton and eased (row < len).
    pub fn parameters(&self, row: usize) -> [f32; MAX_AXES] {
        self.state.blocks[row / LANES].parameters[row % LANES]
    }

    /// Weights of the examples (number of examples, row < len).
    pub fn weights(&self, row: usize) -> &[f32] {
        &self.weights[row * self.space.stride()..][..self.space.examples().len()]
    }

    /// Joints in model space, which [`Walkers::root`] places in the world; heights contain that of the ground
    /// (NUM_JOINTS, row < len).
    pub fn pose(&self, row: usize) -> &[Mat3x4; NUM_JOINTS] {
        &self.model[row]
    }

    /// Joints of all walkers relative to their parents; empty unless the config asks for them (len * NUM_JOINTS).
    pub fn local_transforms(&self) -> &[LocalTransform] {
        &self.locals
    }

    /// Sets viewpoint and distances of the level of detail from the next step on; with none, all walkers are posed whole. Feet
    /// of those that leave records alone report nothing.
    ///
    /// # Errors
    /// [`Error::Value`](throng_base::Error::Value) for invalid distances.
    pub fn set_detail(&mut self, detail: Option<Detail>) -> Result<()> {
        detail.map_or(Ok(()), |detail| detail.check())?;
        self.detail = detail;
        Ok(())
    }

    /// Records of all walkers, whatever their level; empty unless [`WalkersConfig::instances`] (len).
    ///
    /// A record shows the two examples that weigh most, in the size of the database skeleton: a blend of more is not quite
    /// what it shows. Without the bundle's clips, as in a space that was not opened by [`Bundle::blend`](crate::Bundle::blend), it
    /// shows the first row.
    pub fn instances(&self) -> &[PoseInstance] {
        &self.instances
    }

    /// World positions of the joints (m, row < len).
    pub fn joint_positions(&self, row: usize) -> [Vec3; NUM_JOINTS] {
        let root = self.root(row);
        let (turn, move_by) = (root.rotation(), root.translation());
        self.model[row].map(|joint| maths::rotate(turn, joint.translation()) + move_by)
    }

    /// World positions of the bottom of the heel and of the ball (the toe's joint), left foot first (m, row < len).
    pub fn soles(&self, row: usize) -> [[Vec3; 2]; 2] {
        find_soles(&self.bodies[row / LANES], row % LANES, self.root(row), self.pose(row))
    }

    /// Moves all walkers on, range by range.
    fn advance(&mut self, dt_s: f32, run: &dyn Executor) {
        let tick = WalkersTick::new(&self.space, &self.config, dt_s, &self.ground);
        let stride = self.space.stride();
        let n = self.len();
        for (at, (level, block)) in self.levels.iter_mut().zip(&self.state.blocks).enumerate() {
            let whole = DetailLevel::Full;
            *level = self.detail.as_ref().map_or(whole, |d| d.level(&block.root, (n - at * LANES).min(LANES)));
        }
        let mut locals = self.locals.chunks_mut(RANGE_LEN * NUM_JOINTS);
        let mut instances = self.instances.chunks_mut(RANGE_LEN);
        let parts = self.state.blocks.chunks_mut(RANGE_BLOCKS).zip(self.bodies.chunks(RANGE_BLOCKS));
        let parts = parts.zip(self.state.orders.chunks_mut(RANGE_LEN)).zip(self.weights.chunks_mut(RANGE_LEN * stride));
        let parts = parts.zip(self.roots.chunks_mut(RANGE_LEN)).zip(self.model.chunks_mut(RANGE_LEN));
        let parts = parts.zip(self.state.acts.chunks_mut(RANGE_LEN)).zip(self.levels.chunks(RANGE_BLOCKS));
        let ranges = parts.map(|(((((((blocks, bodies), controls), weights), roots), model), acts), levels)| {
            let (locals, instances) = (locals.next().unwrap_or_default(), instances.next().unwrap_or_default());
            WalkerRange { blocks, bodies, levels, controls, acts, weights, roots, model, locals, instances }
        });
        run_each(run, ranges, |range| step::step(range, &tick));
    }

    /// Poses walkers as they stand, on copies of their blocks: nothing moves on.
    fn pose_rows(&mut self, rows: std::ops::Range<usize>) {
        let tick = WalkersTick::new(&self.space, &self.config, 0.0, &self.ground);
        let stride = self.space.stride();
        for b in rows.start / LANES..rows.end.div_ceil(LANES) {
            let from = b * LANES;
            let count = LANES.min(self.len() - from);
            let mut block = self.state.blocks[b];
            let mut controls = [Control::default(); LANES];
            let mut acts = [WalkerActivity::default(); LANES];
            acts[..count].copy_from_slice(&self.state.acts[from..from + count]);
            for (lane, control) in controls[..count].iter_mut().enumerate() {
                let Planar { x, z, heading } = block.root(lane);
                let style = self.state.orders[from + lane].style;
                *control = Control { position: Some([x, z].into()), heading: Some(heading), style, ..*control };
            }
            let mut roots = [Planar::IDENTITY; LANES];
            let mut model = [[Mat3x4::default(); NUM_JOINTS]; LANES];
            let mut locals = [LocalTransform::default(); LANES * NUM_JOINTS];
            let num_locals = if self.config.local_transforms { count * NUM_JOINTS } else { 0 };
            let mut instances = [PoseInstance::default(); LANES];
            let num_instances = if self.config.instances { count } else { 0 };
            let range = WalkerRange {
                blocks: std::slice::from_mut(&mut block),
                bodies: &self.bodies[b..=b],
                levels: &[DetailLevel::Full],
                controls: &mut controls[..count],
                acts: &mut acts[..count],
                weights: &mut self.block_weights[..count * stride],
                roots: &mut roots[..count],
                model: &mut model[..count],
                locals: &mut locals[..num_locals],
                instances: &mut instances[..num_instances],
            };
            step::step(range, &tick);
            for lane in (0..count).filter(|lane| rows.contains(&(from + lane))) {
                let row = from + lane;
                self.roots[row] = self.state.blocks[b].root(lane);
                self.model[row] = model[lane];
                self.weights[row * stride..][..stride].copy_from_slice(&self.block_weights[lane * stride..][..stride]);
                if let Some(to) = self.instances.get_mut(row) {
                    *to = PoseInstance { variant: self.state.roster.ids()[row].index() as u32, ..instances[lane] };
                }
                if let Some(to) = self.locals.get_mut(row * NUM_JOINTS..(row + 1) * NUM_JOINTS) {
                    to.copy_from_slice(&locals[lane * NUM_JOINTS..][..NUM_JOINTS]);
                }
            }
        }
    }

    /// Resizes the output rows to the number of walkers.
    fn resize(&mut self) {
        let n = self.len();
        self.roots.resize(n, Planar::IDENTITY);
        self.model.resize(n, [Mat3x4::default(); NUM_JOINTS]);
        self.weights.resize(n * self.space.stride(), 0.0);
        self.locals.resize(if self.config.local_transforms { n * NUM_JOINTS } else { 0 }, LocalTransform::default());
        self.instances.resize(if self.config.instances { n } else { 0 }, PoseInstance::default());
        self.levels.resize(n.div_ceil(LANES), DetailLevel::Full);
        self.state.blocks.resize(n.div_ceil(LANES), WalkerBlock::ZERO);
        if self.bodies.len() != n.div_ceil(LANES) {
            // Lanes without a walker have a body too, so that nothing is divided by 0.
            self.bodies.resize(n.div_ceil(LANES), LaneBody::from_skeleton(self.space.skeleton()));
        }
    }

    /// Writes the body of a row into its lane.
    fn put_body(&mut self, row: usize) {
        let body = &self.skeletons[self.state.bodies[row] as usize];
        self.bodies[row / LANES].set_body(row % LANES, body, self.space.skeleton());
    }

    fn find_setup(&self, capacity: usize) -> u128 {
        let mut hash = Hash128::default();
        hash.add_bytes(&self.space.hash().to_le_bytes());
        hash.add_word(capacity as u64);
        // What is only written besides changes no motion.
        let config = WalkersConfig { local_transforms: false, instances: false, ..self.config };
        let rest = (self.space.name(), self.space.activities().activities(), &config, &self.skeletons);
        hash.add_bytes(format!("{rest:?}").as_bytes());
        self.ground.hash(&mut hash);
        hash.finish()
    }
}
