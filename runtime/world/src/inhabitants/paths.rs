//! Planned paths of all characters, and the queue of requests for one.

use super::snapshot::{are_steps, is_node};
use crate::plan::{PlanTarget, WorldPlan};
use crate::{WorldGraph, WorldNode, WorldStep};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// The path of one character.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct InhabitantPath {
    /// Target; none for a roaming character.
    pub target: Option<PlanTarget>,
    /// Node that the next step begins at.
    pub from: Option<WorldNode>,
    /// Index of the next step, and of the one after the last that is kept.
    next: usize,
    end: usize,
    plan: Option<WorldPlan>,
    /// True while the character is in the queue.
    asked: bool,
}

/// Paths of all characters, their remaining steps, and the queue of requests.
pub(super) type SavedPaths = (Vec<InhabitantPath>, Vec<Vec<WorldStep>>, Vec<u32>);

/// Paths of all characters; memory for all of them.
#[derive(Debug)]
pub(super) struct InhabitantPaths {
    paths: Vec<InhabitantPath>,
    steps: Vec<WorldStep>,
    max_path: usize,
    /// Characters that wait for a path.
    queue: VecDeque<u32>,
}

impl Clone for InhabitantPaths {
    /// The queue keeps its room: a step allocates nothing.
    fn clone(&self) -> Self {
        let mut queue = VecDeque::with_capacity(self.paths.len());
        queue.extend(&self.queue);
        Self { paths: self.paths.clone(), steps: self.steps.clone(), max_path: self.max_path, queue }
    }
}

impl InhabitantPaths {
    pub fn new(num_characters: usize, max_path: usize) -> Self {
        Self {
            paths: vec![InhabitantPath::default(); num_characters],
            steps: vec![WorldStep::NONE; num_characters * max_path],
            max_path,
            queue: VecDeque::with_capacity(num_characters),
        }
    }

    /// Remaining steps of a path.
    pub fn steps_of(&self, character: usize) -> &[WorldStep] {
        let p = &self.paths[character];
        &self.steps[character * self.max_path..][p.next..p.end]
    }

    /// Remaining steps of a path that begins at a node; empty where it begins elsewhere.
    pub fn start_node(&self, character: usize, node: WorldNode) -> &[WorldStep] {
        if self.paths[character].from == Some(node) { self.steps_of(character) } else { &[] }
    }

    pub fn last_plan(&self, character: usize) -> Option<&WorldPlan> {
        self.paths[character].plan.as_ref()
    }

    pub fn target(&self, character: usize) -> Option<PlanTarget> {
        self.paths[character].target
    }

    /// Removes the first steps of a path.
    pub fn advance(&mut self, character: usize, num_steps: usize) {
        let p = &mut self.paths[character];
        p.next += num_steps;
        p.from = Some(self.steps[character * self.max_path + p.next - 1].to);
    }

    /// Replaces the target of a character, whose path is forgotten.
    pub fn set_target(&mut self, character: usize, target: Option<PlanTarget>) {
        let p = &mut self.paths[character];
        *p = InhabitantPath { target, asked: p.asked, ..InhabitantPath::default() };
    }

    /// Asks for a path.
    pub fn request_path(&mut self, character: usize) {
        let p = &mut self.paths[character];
        if !std::mem::replace(&mut p.asked, true) {
            self.queue.push_back(character as u32);
        }
    }

    /// A character leaves, and the last one takes its place.
    pub fn remove_character(&mut self, character: usize, last: usize) {
        self.queue.retain(|&who| who as usize != character);
        self.queue.iter_mut().filter(|who| **who as usize == last).for_each(|who| *who = character as u32);
        self.paths.swap(character, last);
        self.paths[last] = InhabitantPath::default();
        self.steps.copy_within(last * self.max_path..(last + 1) * self.max_path, character * self.max_path);
    }

    /// The next character that waits for a path.
    pub fn next_waiting(&mut self) -> Option<usize> {
        let character = self.queue.pop_front()? as usize;
        self.paths[character].asked = false;
        Some(character)
    }

    /// State of the first `n` characters' paths, for [`InhabitantPaths::restore`].
    pub fn saved_paths(&self, n: usize) -> SavedPaths {
        let steps = (0..n).map(|c| self.steps_of(c).to_vec());
        (self.paths[..n].to_vec(), steps.collect(), self.queue.iter().copied().collect())
    }

    /// Restores the saved paths of `n` characters (there is room); false where they are inconsistent.
    pub fn restore(&mut self, graph: &WorldGraph, (paths, steps, waiting): &SavedPaths, n: usize) -> bool {
        let is_sound = |(path, steps): (&InhabitantPath, &Vec<WorldStep>)| {
            path.next <= path.end
                && path.end <= self.max_path
                && steps.len() == path.end - path.next
                && path.target.is_none_or(|t| t.exists(graph))
                && (steps.is_empty() || path.from.is_some_and(|from| are_steps(graph, from, steps)))
                && path.from.is_none_or(|from| is_node(graph, from))
        };
        let mut asked = vec![false; n];
        let once = |c: &u32| asked.get_mut(*c as usize).is_some_and(|a| !std::mem::replace(a, true));
        if [paths.len(), steps.len()] != [n; 2] || !waiting.iter().all(once) || !paths.iter().zip(steps).all(is_sound) {
            return false;
        }
        self.paths.fill(InhabitantPath::default());
        self.paths[..n].copy_from_slice(paths);
        for (c, (path, steps)) in self.paths.iter_mut().zip(steps).enumerate() {
            path.asked = asked[c];
            self.steps[c * self.max_path..][path.next..path.end].copy_from_slice(steps);
        }
        self.queue.clear();
        self.queue.reserve(self.paths.len());
        self.queue.extend(waiting);
        true
    }

    /// Room for the steps of a path.
    pub fn step_buffer(&mut self, character: usize) -> &mut [WorldStep] {
        &mut self.steps[character * self.max_path..][..self.max_path]
    }

    /// Sets the path whose steps were written to its slots.
    pub fn set(&mut self, character: usize, from: WorldNode, plan: WorldPlan) {
        let p = &mut self.paths[character];
        (p.from, p.next, p.end, p.plan) = (Some(from), 0, plan.num_stored, Some(plan));
    }
}
