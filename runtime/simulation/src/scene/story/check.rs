//! Checks and scaling of places, values, events, rules and graphs.

use super::{
    ActionConfig, DoorConfig, EventConfig, RelationConfig, SiteConfig, SourceConfig, StoryBehaviour, ThingConfig,
    ValueConfig, WordConfig,
};
use crate::scene::check::{KeyFault, check_numbers, check_point, check_ranges, key_fault};
use crate::{scene::PlaceConfig, scene::goal::scale_points};
/// Multiplies the points of actions.
pub(in crate::scene) fn stretch_actions(actions: &mut [ActionConfig], by: f32) {
    for (word, said) in actions.iter_mut().flatten() {
        match said {
            WordConfig::Point(at) => {
                let height = at.get(1).copied().filter(|_| word == "on");
                scale_points(&mut [at], by);
                // Tables do not grow with the layout.
                at.iter_mut().skip(1).zip(height).for_each(|(y, height)| *y = height);
            }
            WordConfig::Points(all) => all.iter_mut().for_each(|p| scale_points(&mut [p], by)),
            _ => {}
        }
    }
}

impl StoryBehaviour {
    pub(in crate::scene) fn stretch(&mut self, by: f32) {
        if let Self::Actions(actions) = self {
            stretch_actions(actions, by);
        }
    }
}

impl SiteConfig {
    /// Multiplies its position; the shapes of slots and queues stay.
    pub(in crate::scene) fn stretch(&mut self, by: f32) {
        let before = self.at.clone();
        scale_points(&mut [&mut self.at], by);
        let moved: Vec<f32> = self.at.iter().zip(&before).map(|(a, b)| a - b).collect();
        let points = self.slots.iter_mut().flat_map(|s| std::iter::once(&mut s.at).chain(&mut s.facing));
        for point in points.chain(self.queue.iter_mut().flat_map(|q| &mut q.points)) {
            point.iter_mut().zip(&moved).for_each(|(p, m)| *p += m);
        }
    }

    pub(in crate::scene) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
        check_point(&format!("{key}.at"), &self.at, dimensions)?;
        check_numbers(&[(&format!("{key}.radius_m"), self.radius_m, 0.05, 1000.0)])?;
        for (i, slot) in self.slots.iter().enumerate() {
            check_point(&format!("{key}.slots[{i}].at"), &slot.at, dimensions)?;
            if let Some(facing) = &slot.facing {
                check_point(&format!("{key}.slots[{i}].facing"), facing, dimensions)?;
            }
        }
        if let Some(queue) = &self.queue {
            check_numbers(&[(&format!("{key}.queue.spacing_m"), queue.spacing_m, 0.3, 10.0)])?;
            if queue.points.len() < 2 {
                let found = queue.points.len();
                return key_fault(&format!("{key}.queue.points"), format!("expected at least 2 points, found {found}"));
            }
            for (i, point) in queue.points.iter().enumerate() {
                check_point(&format!("{key}.queue.points[{i}]"), point, dimensions)?;
            }
        }
        Ok(())
    }
}

impl DoorConfig {
    pub(in crate::scene) fn stretch(&mut self, by: f32) {
        scale_points(&mut [&mut self.from, &mut self.to], by);
    }

    pub(in crate::scene) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
        check_point(&format!("{key}.from"), &self.from, dimensions)?;
        check_point(&format!("{key}.to"), &self.to, dimensions)?;
        check_numbers(&[(&format!("{key}.radius_m"), self.radius_m, 0.0, 10.0)])
    }
}

impl ValueConfig {
    pub(in crate::scene) fn find_fault(&self, key: &str) -> Result<(), KeyFault> {
        let [low, high] = self.limits;
        if !(low < high && low.abs() < 1e6 && high.abs() < 1e6) {
            let why = format!("expected two numbers that ascend, found {low} and {high}");
            return key_fault(&format!("{key}.limits"), why);
        }
        check_ranges(&[(&format!("{key}.start"), self.start, low, high)])?;
        check_numbers(&[
            (&format!("{key}.rate_per_s"), self.rate_per_s, -1e6, 1e6),
            (&format!("{key}.rest"), self.rest.unwrap_or(low), low, high),
            (&format!("{key}.half_life_s"), self.half_life_s, 0.01, 1e6),
        ])
    }
}

impl EventConfig {
    pub(in crate::scene) fn find_fault(&self, key: &str) -> Result<(), KeyFault> {
        let times = [("at_s", self.at_s, 0.0), ("every_s", self.every_s, 0.01), ("period_s", self.period_s, 0.01)];
        for (name, time, least) in times {
            check_numbers(&[(&format!("{key}.{name}"), time.unwrap_or(least), least, 1e6)])?;
        }
        if let Some([from, to]) = self.between_s
            && !(0.0 <= from && from <= to && to <= 1e6)
        {
            let why = format!("expected two times that ascend from 0, found {from} and {to}");
            return key_fault(&format!("{key}.between_s"), why);
        }
        check_numbers(&[(&format!("{key}.fresh_s"), self.fresh_s.unwrap_or(0.0), 0.0, 1e9)])
    }
}

impl RelationConfig {
    pub(in crate::scene) fn find_fault(&self, key: &str) -> Result<(), KeyFault> {
        if self.friendship.is_none() && self.curiosity.is_none() {
            return key_fault(key, "expected `friendship` or `curiosity`, found neither");
        }
        check_numbers(&[
            (&format!("{key}.share"), self.share, 0.0, 1.0),
            (&format!("{key}.friendship"), self.friendship.unwrap_or(0.0), -1.0, 1.0),
            (&format!("{key}.curiosity"), self.curiosity.unwrap_or(0.0), -1.0, 1.0),
        ])
    }
}

impl SourceConfig {
    pub(in crate::scene) fn find_fault(&self, key: &str, count: usize, dimensions: usize) -> Result<(), KeyFault> {
        if self.start > count {
            let why = format!("expected at most the `count` of the group, {count}, found {}", self.start);
            return key_fault(&format!("{key}.start"), why);
        }
        if self.rates.is_empty() || !self.rates.windows(2).all(|w| w[0][0] < w[1][0]) {
            return key_fault(&format!("{key}.rates"), "expected [from time, per second], in the order of time");
        }
        for (i, [from, rate]) in self.rates.iter().enumerate() {
            check_numbers(&[
                (&format!("{key}.rates[{i}][0]"), *from, 0.0, 1e6),
                (&format!("{key}.rates[{i}][1]"), *rate, 0.0, 1e4),
            ])?;
        }
        if let Some(period) = self.period_s {
            check_numbers(&[(&format!("{key}.period_s"), period, 1.0, 1e6)])?;
        }
        match &self.place {
            Some(place @ PlaceConfig::Block { .. }) => place.find_fault(&format!("{key}.place"), dimensions),
            Some(_) => key_fault(&format!("{key}.place"), "expected a `block`"),
            None => Ok(()),
        }
    }
}

impl ThingConfig {
    pub(in crate::scene) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
        if dimensions != 2 {
            return key_fault(key, "expected none in the air: hands take things on the ground");
        }
        check_point(&format!("{key}.at"), &self.at, 3)?;
        check_numbers(&[(&format!("{key}.at[1]"), self.at[1], 0.0, 10.0)])?;
        let sizes: Vec<_> = (0..3).map(|k| (format!("{key}.size_m[{k}]"), self.size_m[k])).collect();
        sizes.iter().try_for_each(|(key, size)| check_numbers(&[(key, *size, 0.01, 2.0)]))
    }

    /// Multiplies its position, but not its height.
    pub(in crate::scene) fn stretch(&mut self, by: f32) {
        self.at[0] *= by;
        self.at[2] *= by;
    }
}
