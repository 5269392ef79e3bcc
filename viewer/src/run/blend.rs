//! A blended character: at a point of a parameter box, on the path that belongs to the point.

use super::{STEP_HZ, blending::Blending, reel::Reel};
use crate::bundle::OpenBundle;
use glam::Vec2;
use throng_core::blend::{BlendSpace, MAX_AXES, axis};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{CharacterGroup, Contacts, Error, Id, Inline, Mat3x4, NUM_JOINTS, Planar, Skeleton};
use throng_simulation::wander::scaled_skeleton;

/// Time in which the difference between the requested and the blended point halves (s).
const HALF_LIFE_S: f32 = 0.12;
/// Distance of characters walking side by side (m).
const BESIDE_M: f32 = 1.1;
/// Distance from the origin at which the walk restarts, before rounding shows (m).
const FAR_M: f32 = 5000.0;
/// All of them at one step.
#[derive(Clone, Debug, Default)]
pub struct BlendMoment {
    /// Planar roots (number of people).
    pub roots: Vec<Planar>,
    /// Joints in model space (number of people * NUM_JOINTS).
    pub poses: Vec<Mat3x4>,
    /// Contacts (number of people).
    pub contacts: Vec<Contacts>,
    /// The blended point, which approaches the requested one.
    pub point: [f32; MAX_AXES],
    /// Generic time of the selected one, in [0, 1).
    pub phase: f32,
    /// Weights of the examples in the selected one (number of examples).
    pub weights: Vec<f32>,
}

/// One walking character.
#[derive(Clone, Debug)]
struct BlendWalker {
    walkers: Walkers,
    id: Id,
    body: Skeleton,
    /// Offset from the first one (m).
    aside: Vec2,
}

/// A character walking at a point of a parameter box, and optional companions.
#[derive(Clone, Debug)]
pub struct BlendRun {
    blending: Blending,
    people: Vec<BlendWalker>,
    /// All of them at the recorded steps.
    pub reel: Reel<BlendMoment>,
    /// Present position and direction of the path.
    place: Planar,
    /// The point that is blended.
    point: [f32; MAX_AXES],
}

impl BlendRun {
    /// A character that starts to walk in the first space of a bundle; none if it has no space.
    ///
    /// # Errors
    /// A message where the tables do not fit together.
    pub fn new(bundle: &OpenBundle) -> Option<Result<Self, String>> {
        let first = bundle.blends.first()?;
        let run = Self::starting_at(bundle, Blending::straight_walk(0, first), Planar::IDENTITY, 0.0);
        Some(run.map_err(|e| e.to_string()))
    }

    fn starting_at(bundle: &OpenBundle, blending: Blending, place: Planar, phase: f32) -> Result<Self, Error> {
        let space = bundle.blend(blending.space)?;
        let blending = blending.limited(space);
        let database = bundle.tables().skeleton();
        let person = |(i, (size, legs, retarget)): (usize, (f32, f32, bool))| {
            let body = scaled_skeleton(database, size, legs);
            // The point itself is eased; its parameters take effect at once.
            let config = {
                let mut config = WalkersConfig { parameter_half_life_s: 0.0, ..WalkersConfig::default() };
                config.foot_lock.enabled = retarget;
                config
            };
            let side = if i % 2 == 1 { 1.0 } else { -1.0 };
            let aside = Vec2::X * side * BESIDE_M * i.div_ceil(2) as f32;
            let root = Planar::new(place.x + aside.x, place.z + aside.y, place.heading);
            let start = WalkerStart { body: 0, root, phase };
            let mut walkers = Walkers::with_capacity(space.clone(), std::slice::from_ref(&body), config, 1)?;
            let id = walkers.spawn(start)?;
            Ok(BlendWalker { walkers, id, body, aside })
        };
        let people = blending.people().into_iter().enumerate().map(person).collect::<Result<Vec<_>, Error>>()?;
        let bytes = people.len() * NUM_JOINTS * size_of::<Mat3x4>() + size_of::<BlendMoment>();
        let reel = Reel::new(bytes, BlendMoment::default());
        let mut run = Self { blending, people, reel, place, point: blending.point };
        run.walk(space, database, 0.0)?;
        run.reel.replace(run.current_moment());
        Ok(run)
    }

    /// The blended point, and the body.
    pub fn blending(&self) -> &Blending {
        &self.blending
    }

    /// Skeletons of the walking characters, the selected one first.
    pub fn bodies(&self) -> impl ExactSizeIterator<Item = &Skeleton> {
        self.people.iter().map(|p| &p.body)
    }

    /// Blends something else, or on another body, from here on; numbers out of range are limited.
    ///
    /// A point that is moved while time stands still is shown at once, at the same generic time.
    ///
    /// # Errors
    /// [`Error`] for a space that does not exist.
    pub fn blend(&mut self, bundle: &OpenBundle, wanted: Blending) -> Result<(), Error> {
        let space = bundle.blend(wanted.space)?;
        let wanted = wanted.limited(space);
        if !wanted.has_same_people(&self.blending) {
            let (head, phase) = (self.reel.head, self.people.first().map_or(0.0, |p| p.walkers.phase(0)));
            *self = Self::starting_at(bundle, wanted, self.place, phase)?;
            self.reel.head.play_like(&head);
            return Ok(());
        }
        let has_moved = wanted.point != self.blending.point;
        self.blending = wanted;
        if has_moved && !self.reel.head.is_playing() {
            self.point = wanted.point;
            self.walk(space, bundle.tables().skeleton(), 0.0)?;
            self.reel.replace(self.current_moment());
        }
        Ok(())
    }

    /// Restarts where the path started.
    ///
    /// # Errors
    /// As [`BlendRun::blend`].
    pub fn restart(&mut self, bundle: &OpenBundle) -> Result<(), Error> {
        let head = self.reel.head;
        *self = Self::starting_at(bundle, self.blending, Planar::IDENTITY, 0.0)?;
        self.reel.head.play_like(&head);
        Ok(())
    }

    /// One step forward: a recorded one, or a new one.
    ///
    /// # Errors
    /// [`Error`] where the bundle is another one.
    pub fn step(&mut self, bundle: &OpenBundle) -> Result<(), Error> {
        if self.reel.head.advance_recorded() {
            return Ok(());
        }
        let space = bundle.blend(self.blending.space)?;
        if self.place.x.hypot(self.place.z) > FAR_M {
            return self.restart(bundle);
        }
        let dt_s = 1.0 / STEP_HZ;
        let left = (-dt_s / HALF_LIFE_S).exp2();
        self.point.iter_mut().zip(self.blending.point).for_each(|(p, wanted)| *p = wanted + (*p - wanted) * left);
        self.walk(space, bundle.tables().skeleton(), dt_s)?;
        self.reel.push(self.current_moment());
        Ok(())
    }

    /// Moves all of them along the path of the point.
    fn walk(&mut self, space: &BlendSpace, database: &Skeleton, dt_s: f32) -> Result<(), Error> {
        let leg = |s: &Skeleton| s.leg_length();
        // Scale of speeds on this body (Froude numbers, as walkers use them).
        let pace = self.people.first().map_or(1.0, |p| (leg(&p.body) / leg(database)).sqrt());
        let mut weights = vec![0.0; space.stride()];
        space.weights(&[self.point], &mut weights)?;
        let ([left, ahead], gyration) = movement(space, &self.point, &weights);
        let turning = gyration / pace;
        // The arc is stepped at its middle, which is exact to the second order.
        let (sin, cos) = (self.place.heading + 0.5 * turning * dt_s).sin_cos();
        let velocity = pace * Vec2::new(cos * left + sin * ahead, cos * ahead - sin * left);
        self.place.x += velocity.x * dt_s;
        self.place.z += velocity.y * dt_s;
        self.place.heading += turning * dt_s;
        let mut style = [0.0; MAX_AXES];
        let styles = space.axes().iter().zip(self.point).filter(|(a, _)| a.kind == axis::STYLE);
        style.iter_mut().zip(styles).for_each(|(s, (_, value))| *s = value);
        let (sin, cos) = self.place.heading.sin_cos();
        let velocity = pace * Vec2::new(cos * left + sin * ahead, cos * ahead - sin * left);
        for person in &mut self.people {
            let control = Control {
                position: Some(Vec2::new(self.place.x, self.place.z) + person.aside),
                velocity,
                heading: Some(self.place.heading),
                turning_rate: Some(turning),
                style,
                ..Control::default()
            };
            person.walkers.order(person.id, control)?;
            person.walkers.step(dt_s, &Inline)?;
        }
        Ok(())
    }

    /// All of them now.
    fn current_moment(&self) -> BlendMoment {
        let all = || self.people.iter().map(|p| &p.walkers);
        let first = all().next();
        BlendMoment {
            roots: all().map(|w| w.root(0)).collect(),
            poses: all().flat_map(|w| w.pose(0)).copied().collect(),
            contacts: all().map(|w| w.contacts(0)).collect(),
            point: self.point,
            phase: first.map_or(0.0, |w| w.phase(0)),
            weights: first.map_or(Vec::new(), |w| w.weights(0).to_vec()),
        }
    }
}

/// Velocity of a point on the database skeleton, to the left and ahead, and its turning rate. Quantities without an
/// axis in the space are those of its examples (m/s, rad/s).
fn movement(space: &BlendSpace, point: &[f32; MAX_AXES], weights: &[f32]) -> ([f32; 2], f32) {
    let on = |kind| space.axis_of(kind).map(|a| point[a]);
    let mean = |of: &dyn Fn(usize) -> f32| -> f32 {
        weights.iter().take(space.examples().len()).enumerate().map(|(e, w)| w * of(e)).sum()
    };
    let velocity = match (on(axis::SIDE), on(axis::SPEED)) {
        (None, None) => [0, 1].map(|k| mean(&|e| space.examples()[e].velocity[k])),
        (left, ahead) => [left.unwrap_or(0.0), ahead.unwrap_or(0.0)],
    };
    let gyration = on(axis::GYRATION).unwrap_or_else(|| mean(&|e| space.examples()[e].gyration));
    (velocity, gyration)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paces::Paces;
    use crate::run::BlendCompanions;

    fn open() -> (Paces, OpenBundle, BlendRun) {
        let paces = Paces::new();
        let bundle = OpenBundle::open(&paces.bundle()).unwrap();
        let run = BlendRun::new(&bundle).unwrap().unwrap();
        (paces, bundle, run)
    }

    fn walk(run: &mut BlendRun, bundle: &OpenBundle, seconds: f32) {
        (0..(seconds * STEP_HZ) as u32).for_each(|_| run.step(bundle).unwrap());
    }

    #[test]
    fn a_point_is_walked_at_its_speed_and_turning_rate() {
        let (_paces, bundle, mut run) = open();
        let [speed, turning] = [0, 1].map(|a| bundle.blends[0].axes()[a]);
        assert_eq!((speed.kind, turning.kind), (axis::SPEED, axis::GYRATION));
        let mut wanted = *run.blending();
        wanted.point[..2].copy_from_slice(&[1.2, 0.4]);
        run.blend(&bundle, wanted).unwrap();
        walk(&mut run, &bundle, 2.0);
        let before = run.reel.moment().clone();
        walk(&mut run, &bundle, 1.0);
        let now = run.reel.moment();
        let turned = now.roots[0].heading - before.roots[0].heading;
        assert!((turned - 0.4).abs() < 0.02, "turned by {turned} rad in a second");
        // The chord of the arc.
        let apart = (now.roots[0].x - before.roots[0].x).hypot(now.roots[0].z - before.roots[0].z);
        let chord = 2.0 * (1.2 / 0.4) * (0.5f32 * 0.4).sin();
        assert!((apart - chord).abs() < 0.02, "{apart} m, expected {chord}");
        assert!((now.weights.iter().sum::<f32>() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_small_body_walks_slower_at_the_same_point() {
        let (_paces, bundle, mut run) = open();
        let small = Blending { size: 0.7, ..*run.blending() };
        run.blend(&bundle, small).unwrap();
        walk(&mut run, &bundle, 1.0);
        let before = run.reel.moment().roots[0];
        walk(&mut run, &bundle, 1.0);
        let distance = (run.reel.moment().roots[0].z - before.z) / run.blending().point[0];
        assert!((distance - 0.7f32.sqrt()).abs() < 0.02, "{distance}");
        let hips = run.reel.moment().poses[0].translation().y;
        assert!((hips / bundle.tables().skeleton().offsets[0].y - 0.7).abs() < 0.05, "hips at {hips} m");
    }

    #[test]
    fn a_point_moved_while_time_stands_is_shown_at_the_same_generic_time() {
        let (_paces, bundle, mut run) = open();
        walk(&mut run, &bundle, 1.5);
        let (steps, before) = (run.reel.head.shown_step(), run.reel.moment().clone());
        run.reel.head.seek(3);
        let mut wanted = *run.blending();
        wanted.point[0] = bundle.blends[0].axes()[0].high + 5.0;
        run.blend(&bundle, wanted).unwrap();
        let now = run.reel.moment();
        assert_eq!((run.reel.head.shown_step(), now.phase), (steps, before.phase));
        assert_eq!(now.point[0], bundle.blends[0].axes()[0].high, "clamped to the box");
        assert!(now.poses != before.poses && now.weights != before.weights);
    }

    #[test]
    fn companions_walk_the_same_path() {
        let (_paces, bundle, mut run) = open();
        run.blend(&bundle, Blending { companions: BlendCompanions::Sizes, ..*run.blending() }).unwrap();
        walk(&mut run, &bundle, 2.0);
        let m = run.reel.moment();
        assert_eq!((m.roots.len(), m.poses.len(), run.bodies().len()), (3, 3 * NUM_JOINTS, 3));
        let hips = [0, 1, 2].map(|i| m.poses[i * NUM_JOINTS].translation().y);
        assert!(hips[1] < hips[0] && hips[0] < hips[2], "{hips:?}");
        assert!((m.roots[1].z - m.roots[0].z).abs() < 1e-4 && (m.roots[1].x - m.roots[0].x - BESIDE_M).abs() < 1e-4);
        run.blend(&bundle, Blending { companions: BlendCompanions::Retargeting, ..*run.blending() }).unwrap();
        walk(&mut run, &bundle, 0.5);
        let m = run.reel.moment();
        assert_eq!(m.roots.len(), 2);
        assert!(m.poses[..NUM_JOINTS] != m.poses[NUM_JOINTS..]);
    }

    #[test]
    fn a_walk_restarts() {
        let (_paces, bundle, mut run) = open();
        let first = run.reel.moment().clone();
        walk(&mut run, &bundle, 1.0);
        run.reel.head.play(true);
        run.restart(&bundle).unwrap();
        assert!(run.reel.head.is_playing() && run.reel.head.shown_step() == 0);
        assert!(run.reel.moment().poses == first.poses && run.reel.moment().roots == first.roots);
        assert!(run.blend(&bundle, Blending { space: 99, ..*run.blending() }).is_err());
    }
}
