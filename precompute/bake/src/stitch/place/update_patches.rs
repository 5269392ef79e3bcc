//! Updates placed patches after the change of one unit, looking only at its surroundings.

use super::change::EnvironmentEdit;
use super::fit::{FittedPatch, UnitIndex};
use super::place_patches::{PlacedPatches, Placer};
use super::relation::RelativePlacement;
use crate::environment::Environment;
use throng_core::patch::NONE;
use throng_geometry::BoundingBox;

/// Updated placed patches, with their unchanged part.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct UpdatedPlacement {
    /// Placed patches of the changed environment.
    pub patches: PlacedPatches,
    /// Unchanged part.
    pub kept: KeptInstances,
}

/// Part of the placed patches that a change left as it was.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::stitch) struct KeptInstances {
    /// Previous number of each instance; [`NONE`] for new ones.
    pub previous_of: Vec<u32>,
    /// True for instances that are not new and have unchanged surrounding units (instances).
    pub is_alike: Vec<bool>,
    /// Previous number of each pair; [`NONE`] for new ones (pairs).
    pub previous_pair_of: Vec<u32>,
    /// Relative placements of new obstacles to instances.
    pub new_obstacles: Vec<RelativePlacement>,
    /// Relations of removed pairs, and of removed obstacles to instances.
    pub removed: [Vec<RelativePlacement>; 2],
}

/// The placed unit that was changed.
#[derive(Clone, Copy, Debug)]
struct ChangedUnit {
    /// Its previous number; `None` if it is new.
    before: Option<u32>,
    /// Its new number; `None` if it was removed.
    after: Option<u32>,
}

impl ChangedUnit {
    /// Determined from the reverse `back` of a change already made.
    fn from_undo(back: &EnvironmentEdit) -> Self {
        match *back {
            EnvironmentEdit::Move { index, .. } => Self { before: Some(index as u32), after: Some(index as u32) },
            EnvironmentEdit::Remove { index } => Self { before: None, after: Some(index as u32) },
            EnvironmentEdit::Insert { index, .. } => Self { before: Some(index as u32), after: None },
        }
    }

    /// New number of another unit.
    fn number_after(self, before: u32) -> u32 {
        match (self.before, self.after) {
            (None, Some(new)) if before >= new => before + 1,
            (Some(gone), None) if before > gone => before - 1,
            _ => before,
        }
    }
}

impl Placer<'_> {
    /// Placed patches of an environment with one changed unit; `None` if it is invalid, for which [`Placer::place_patches`] gives
    /// the error.
    ///
    /// - `before`: placed patches before the change.
    /// - `back`: reverse of the change.
    pub fn update_patches(
        &self,
        environment: &Environment,
        before: &PlacedPatches,
        back: &EnvironmentEdit,
    ) -> Option<UpdatedPlacement> {
        let changed = ChangedUnit::from_undo(back);
        let (now, placed, kept) = (vec![NONE; before.fitted.len()], PlacedPatches::default(), KeptInstances::default());
        let mut update = PatchUpdate { placer: self, environment, before, changed, now, placed, kept };
        update.renew_shapes()?;
        if let Some(unit) = changed.after
            && !self.is_free(environment, &update.placed.shapes, unit as usize)
        {
            return None;
        }
        update.refit();
        self.check_cover(environment, &update.placed.fitted).ok()?;
        update.renew_neighbours();
        update.renew_pairs();
        update.renew_obstacles();
        Some(UpdatedPlacement { patches: update.placed, kept: update.kept })
    }

    /// All patches that fit near a unit, including all that it belongs to.
    fn fit_around(&self, environment: &Environment, unit: u32) -> Vec<FittedPatch> {
        let far = |(_, at): &(usize, throng_core::patch::Placement)| at.translation().length();
        let widest = self.patterns.iter().flat_map(|p| p.units.iter().map(far)).fold(0.0, f32::max);
        let at = environment.units[unit as usize].placement.translation();
        let apart = |i: u32| (environment.units[i as usize].placement.translation() - at).length();
        let all = || 0..environment.units.len() as u32;
        // Units of one set are at most that far apart, and further ones that fit with them as far again.
        let index = UnitIndex::from_units(environment, all().filter(|&i| apart(i) < 4.0 * widest + 1.0));
        self.fit_patches(&index, all().filter(|&i| apart(i) < 2.0 * widest + 0.5))
    }
}

/// An update of placed patches. Remaining instances keep their order, and so does all that is sorted by it.
struct PatchUpdate<'u> {
    placer: &'u Placer<'u>,
    environment: &'u Environment,
    before: &'u PlacedPatches,
    changed: ChangedUnit,
    /// New number of each previous instance; [`NONE`] for removed ones.
    now: Vec<u32>,
    placed: PlacedPatches,
    kept: KeptInstances,
}

impl PatchUpdate<'_> {
    /// Bounds of all units; `None` if the changed one is not one of the bundle's.
    fn renew_shapes(&mut self) -> Option<()> {
        let mut shapes = self.before.shapes.clone();
        if let Some(unit) = self.changed.before {
            shapes.remove(unit as usize);
        }
        if let Some(unit) = self.changed.after {
            let placed = &self.environment.units[unit as usize];
            shapes.insert(unit as usize, self.placer.is_known(placed).then(|| self.placer.pattern_bounds(placed))?);
        }
        self.placed.shapes = shapes;
        Some(())
    }

    /// Instances with their bounds, and the previous number of each.
    fn refit(&mut self) {
        let (before, changed) = (self.before, self.changed);
        let is_left = |f: &FittedPatch| changed.before.is_none_or(|unit| !f.units.contains(&unit));
        let numbered = |f: &FittedPatch| {
            let units = f.units.iter().map(|&u| changed.number_after(u)).collect();
            FittedPatch { units, ..f.clone() }
        };
        let left = (0u32..).zip(&before.fitted).filter(|(_, f)| is_left(f)).map(|(was, f)| (numbered(f), was));
        let mut all: Vec<(FittedPatch, u32)> = left.collect();
        if let Some(unit) = changed.after {
            let new = self.placer.fit_around(self.environment, unit);
            all.extend(new.into_iter().filter(|f| f.units.contains(&unit)).map(|f| (f, NONE)));
            all.sort_by_key(|(f, _)| f.sort_key());
        }
        let bounds = |(f, was): &(FittedPatch, u32)| {
            before.bounds.get(*was as usize).copied().unwrap_or_else(|| self.placer.instance_bounds(f))
        };
        self.placed.bounds = all.iter().map(bounds).collect();
        (self.placed.fitted, self.kept.previous_of) = all.into_iter().unzip();
        self.kept.is_alike = self.kept.previous_of.iter().map(|&was| was != NONE).collect();
        for (i, &was) in (0u32..).zip(&self.kept.previous_of).filter(|(_, was)| **was != NONE) {
            self.now[was as usize] = i;
        }
    }

    fn renew_neighbours(&mut self) {
        let Self { placer, before, now, placed, kept, .. } = self;
        let was = &kept.previous_of;
        let is_tile = |f: &FittedPatch| placer.patterns[f.patch as usize].is_tile;
        let is_new = placed.fitted.iter().zip(was).any(|(f, was)| *was == NONE && is_tile(f));
        let is_gone = before.fitted.iter().zip(&*now).any(|(f, now)| *now == NONE && is_tile(f));
        if is_new || is_gone {
            let found = placer.neighbours(&UnitIndex::new(self.environment), &placed.fitted);
            (placed.neighbours, placed.first_neighbour) = found;
            return;
        }
        for (f, &was) in placed.fitted.iter().zip(was) {
            placed.first_neighbour.push(placed.neighbours.len() as u32);
            if is_tile(f) {
                let first = before.first_neighbour[was as usize] as usize;
                let own = &before.neighbours[first..first + placer.patches.edges_of(f.patch as usize).len()];
                placed.neighbours.extend(own.iter().map(|&o| if o == NONE { NONE } else { now[o as usize] }));
            }
        }
    }

    fn renew_pairs(&mut self) {
        let Self { placer, before, now, placed, kept, .. } = self;
        let mut pairs: Vec<((u32, u32, RelativePlacement), u32)> = Vec::with_capacity(before.pairs.len());
        for (k, &(a, b, relation)) in (0u32..).zip(&before.pairs) {
            match (now[a as usize], now[b as usize]) {
                (NONE, _) | (_, NONE) => kept.removed[0].push(relation),
                (a, b) => pairs.push(((a, b, relation), k)),
            }
        }
        let num_left = pairs.len();
        for new in (0..placed.fitted.len() as u32).filter(|&i| kept.previous_of[i as usize] == NONE) {
            let near = overlapped(&placed.bounds, &placed.bounds[new as usize]);
            // A pair of new instances is handled from the first of them.
            let others = near.filter(|&o| o != new && (kept.previous_of[o as usize] != NONE || o > new));
            let pair = |o: u32| placer.pair(&placed.fitted, new.min(o), new.max(o));
            pairs.extend(others.filter_map(pair).map(|pair| (pair, NONE)));
        }
        merge(&mut pairs, num_left);
        (placed.pairs, kept.previous_pair_of) = pairs.into_iter().unzip();
    }

    fn renew_obstacles(&mut self) {
        let Self { environment, before, changed, now, placed, kept, .. } = self;
        let mut obstacles = Vec::with_capacity(before.obstacles.len());
        for &(i, unit, relation) in &before.obstacles {
            let i = now[i as usize];
            if i != NONE && Some(unit) != changed.before {
                obstacles.push((i, changed.number_after(unit), relation));
                continue;
            }
            kept.removed[1].push(relation);
            if let Some(is_alike) = kept.is_alike.get_mut(i as usize) {
                *is_alike = false;
            }
        }
        let num_left = obstacles.len();
        for (i, &was) in (0u32..).zip(&kept.previous_of) {
            let bounds = &placed.bounds[i as usize];
            let near = |unit: &u32| bounds.min.is_finite() && placed.shapes[*unit as usize].overlaps(bounds);
            let fitted = &placed.fitted[i as usize];
            let to = |unit: u32| Some((i, unit, fitted.obstacle(unit, &environment.units[unit as usize])?));
            match was {
                NONE => obstacles.extend((0..placed.shapes.len() as u32).filter(near).filter_map(to)),
                _ => {
                    let new = changed.after.filter(near).and_then(to);
                    kept.is_alike[i as usize] &= new.is_none();
                    obstacles.extend(new);
                }
            }
        }
        kept.new_obstacles = obstacles[num_left..].iter().map(|o| o.2).collect();
        merge(&mut obstacles, num_left);
        placed.obstacles = obstacles;
    }
}

/// Sorts a list with a sorted prefix of known length.
fn merge<T: Ord>(list: &mut [T], sorted: usize) {
    list[sorted..].sort_unstable();
    // Two sorted runs, which a stable sort only merges.
    list.sort();
}

/// Numbers of the boxes that overlap one; ascending.
fn overlapped(all: &[BoundingBox], one: &BoundingBox) -> impl Iterator<Item = u32> {
    let overlaps =
        |(i, b): (u32, &BoundingBox)| (b.overlaps(one) && b.min.is_finite() && one.min.is_finite()).then_some(i);
    (0u32..).zip(all).filter_map(overlaps)
}

#[cfg(test)]
mod tests;
