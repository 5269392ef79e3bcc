//! Intentions of the boxer: footwork, combinations and defences, dealt in equal numbers.

use super::attack::{self, Attack, BlowLevel};
use super::moves::{COMBINATIONS, Defence, FOOTWORK, HandPunch, Shuffle};
use super::{BoxingHandPose, BoxingPosture, BoxingScript, ScriptedBlow, technique};
use crate::deck::CardDeck;
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};
use throng_core::Skeleton;

/// Time of standing on guard at both ends of a clip (s).
const STAND: f64 = 0.8;
/// Time from the last hit of a combination to the guard (s).
const RECOVER: f64 = 0.38;
/// Time from the hit to the body's furthest point, as it drives through (s).
const THROUGH: f64 = 0.1;
/// Time by which the body gathers before a later blow of a combination (s).
const IN_BETWEEN: f64 = 0.17;

/// Dealer of moves. One serves all clips of a set, so that moves are spread evenly over it.
pub struct BoxingDealer {
    combinations: CardDeck<&'static [HandPunch]>,
    footwork: CardDeck<Shuffle>,
    defences: CardDeck<Defence>,
    levels: [CardDeck<BlowLevel>; 3],
    azimuths: CardDeck<f64>,
    reaches: CardDeck<f64>,
    moves: CardDeck<usize>,
    variation: f64,
}

impl BoxingDealer {
    /// A dealer whose moves vary by `variation` times the usual amount.
    pub fn new(variation: f64) -> Self {
        use BlowLevel::{Body, Head, High};
        Self {
            combinations: CardDeck::new(&COMBINATIONS),
            footwork: CardDeck::new(&FOOTWORK),
            defences: CardDeck::new(&Defence::ALL),
            levels: [
                CardDeck::new(&[Body, Head, Head, Head, High]),
                CardDeck::new(&[Body, Head, Head, High]),
                CardDeck::new(&[Body, Head, Head, High]),
            ],
            azimuths: CardDeck::new(&[-0.38, -0.26, -0.14, -0.07, 0.0, 0.0, 0.07, 0.14, 0.26, 0.38]),
            reaches: CardDeck::new(&[-1.0, -0.5, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0]),
            moves: CardDeck::new(&[1, 1, 2, 2, 3]),
            variation,
        }
    }

    /// Script of shadow-boxing for about `seconds`, from guard to guard.
    pub fn shadow_box(&mut self, seconds: f64, skeleton: &Skeleton, rng: &mut impl Rng) -> BoxingScript {
        let mut script = BoxingScript::new(skeleton);
        let mut now = STAND;
        while now < seconds - STAND {
            now = self.move_about(&mut script, now, rng);
            if rng.random_bool(0.35) {
                now = self.defend(&mut script, now, rng);
            }
            now = self.attack(&mut script, now, rng);
            now = match rng.random_range(0..10) {
                0..4 => self.defend(&mut script, now, rng),
                4..7 => self.shuffle(&mut script, now - 0.16, rng),
                _ => now,
            };
        }
        script.duration = now.max(script.feet_free) + STAND;
        script
    }

    /// Random factor around 1.
    fn random_factor(&self, amount: f64, rng: &mut impl Rng) -> f64 {
        1.0 + self.variation * amount * rng.random_range(-1.0..1.0)
    }

    /// Some footwork, with short rests between.
    fn move_about(&mut self, script: &mut BoxingScript, mut now: f64, rng: &mut impl Rng) -> f64 {
        for _ in 0..self.moves.deal(rng) {
            now = self.shuffle(script, now, rng);
            if rng.random_bool(0.5) {
                now += rng.random_range(0.05..0.35);
            }
        }
        now
    }

    fn shuffle(&mut self, script: &mut BoxingScript, now: f64, rng: &mut impl Rng) -> f64 {
        let mut shuffle = self.footwork.deal(rng);
        let scale = self.random_factor(0.2, rng);
        shuffle.forward *= scale;
        shuffle.aside *= scale;
        shuffle.turn *= self.random_factor(0.2, rng);
        let start = now.max(script.feet_free);
        let end = self.step(script, now, &shuffle, rng);
        if shuffle.turn.abs() > 0.5 {
            // The lead foot turns on its ball with its heel lifted.
            let (_, mut up) = script.body.last();
            up.heels[0] = 0.14;
            script.body.hold(start - 0.03);
            script.body.push(start + 0.1, up);
            self.recover(script, end + 0.1, rng);
        } else if rng.random_bool(0.6) {
            script.body.hold(start);
            self.recover(script, end, rng);
        }
        end
    }

    fn step(&self, script: &mut BoxingScript, at: f64, shuffle: &Shuffle, rng: &mut impl Rng) -> f64 {
        let quickness = self.random_factor(0.1, rng);
        let error = [0, 1].map(|_| {
            let mut miss = || self.variation * rng.random_range(-0.014..0.014);
            DVec2::new(miss(), miss())
        });
        script.shuffle(at, shuffle, quickness, error)
    }

    /// Returns to guard, with random variation.
    fn recover(&self, script: &mut BoxingScript, t: f64, rng: &mut impl Rng) {
        let mut by = |amount: f64| self.variation * amount * rng.random_range(-1.0..1.0);
        let guard = BoxingPosture::GUARD;
        let body = BoxingPosture {
            hips: guard.hips + by(0.05),
            chest: guard.chest + by(0.06),
            pitch: guard.pitch + by(0.025),
            list: by(0.02),
            flexion: guard.flexion + by(0.05),
            weight: guard.weight + by(0.05),
            heels: [0.0, guard.heels[1] + by(0.07)],
            ..guard
        };
        script.body.push(t, body);
        for (track, mut hand) in script.hands.iter_mut().zip(BoxingHandPose::GUARD) {
            hand.guard += DVec3::new(by(0.012), by(0.015), by(0.016));
            track.push(t, hand);
        }
    }

    fn defend(&mut self, script: &mut BoxingScript, now: f64, rng: &mut impl Rng) -> f64 {
        let defence = self.defences.deal(rng);
        let pace = self.random_factor(0.12, rng);
        script.body.hold(now);
        script.hands.iter_mut().for_each(|h| h.hold(now));
        let mut end = now;
        for moment in technique::defend(defence) {
            end = now + pace * moment.time;
            script.body.push(end, moment.body);
            script.hands.iter_mut().zip(moment.hands).for_each(|(track, hand)| track.push(end, hand));
        }
        let held = end + rng.random_range(0.03..0.14);
        script.body.hold(held);
        script.hands.iter_mut().for_each(|h| h.hold(held));
        let back = held + pace * if defence == Defence::Duck { 0.34 } else { 0.26 };
        self.recover(script, back, rng);
        script.tags.push((defence.tag(), now, back));
        back
    }

    /// Adds a combination, often with a step into it.
    fn attack(&mut self, script: &mut BoxingScript, now: f64, rng: &mut impl Rng) -> f64 {
        let combination = self.combinations.deal(rng);
        let attack = Attack {
            azimuth: self.azimuths.deal(rng),
            reach: self.reaches.deal(rng),
            tempo: self.random_factor(0.1, rng),
        };
        let mut hit = self.step_in(script, now, combination[0], attack.reach, rng);
        script.body.hold(now);
        for (i, &blow) in combination.iter().enumerate() {
            if i > 0 {
                let usual = attack::seconds_between_hits(combination[i - 1], blow);
                hit += attack.tempo * self.random_factor(0.06, rng) * usual;
            }
            self.strike(script, blow, hit, i == 0, &attack, rng);
        }
        let end = hit + RECOVER;
        self.recover(script, end, rng);
        script.tags.push(("combination", now, end));
        end
    }

    /// Steps in before a long attack.
    ///
    /// - returns the time of the first hit.
    fn step_in(&self, script: &mut BoxingScript, now: f64, first: HandPunch, reach: f64, rng: &mut impl Rng) -> f64 {
        let technique = technique::technique_of(first);
        let ready = technique.load.map_or(technique.extend, |(before, _)| technique.extend.max(before + 0.14));
        if reach < 0.3 {
            return now + ready;
        }
        let forward = 0.1 + 0.16 * reach;
        let step = Shuffle { forward, aside: 0.0, turn: 0.0, tag: Some("step_in") };
        let start = now.max(script.feet_free);
        self.step(script, start, &step, rng);
        (now + ready).max(start + 0.25)
    }

    fn strike(
        &mut self,
        script: &mut BoxingScript,
        blow: HandPunch,
        hit: f64,
        first: bool,
        attack: &Attack,
        rng: &mut impl Rng,
    ) {
        let technique = technique::technique_of(blow);
        let level = self.levels[blow.punch as usize].deal(rng);
        let height = attack.height(blow.punch, level, rng);
        let speed = technique.speed * self.random_factor(0.16, rng);
        let azimuth = attack.azimuth + self.variation * rng.random_range(-0.06..0.06);
        let longest = hit + technique.braking(speed);
        let (start, back) = (hit - technique.extend, longest + technique.retract);
        let side = blow.side().index();
        let attack = Attack { azimuth, ..*attack };
        let aimed = |p: BoxingPosture, share: f64| attack.aim_posture(&technique, p, height, share);
        if let Some((before, load)) = technique.load {
            let before = if first { before } else { before.min(IN_BETWEEN) };
            script.body.push(hit - before, aimed(load, 0.5));
        }
        script.body.push(hit + THROUGH, aimed(technique.strike, 1.0));
        let hand = &mut script.hands[side];
        hand.hold(start);
        hand.push(hit, technique.arm);
        hand.push(longest + 0.55 * technique.retract, BoxingHandPose::GUARD[side]);
        if let Some(last) = script.strikes.iter_mut().rev().find(|s| s.blow.side() == blow.side()) {
            last.back = last.back.min(start);
        }
        let stretch = technique.stretch * attack.stretch(blow.punch);
        script.strikes.push(ScriptedBlow { blow, start, hit, longest, back, azimuth, height, stretch, speed });
        script.tags.push((blow.tag(), start, back));
    }
}
