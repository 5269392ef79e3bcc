//! Expectations: conditions that a run of a scene has to meet.

use super::check::{KeyFault, check_numbers, key_fault};
use serde::{Deserialize, Serialize};

/// Expectation: what must be true of a run, for `throng check SCENE --run`. A condition that nothing was measured for is broken, too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ExpectConfig {
    /// Sentence that must be true, for messages.
    pub name: String,
    /// Quantity that is measured.
    pub that: ExpectedQuantity,
    /// Groups that it is about; all where empty.
    #[serde(default)]
    pub who: Vec<String>,
    /// Range of times in which it is measured; the whole run where absent (s).
    pub between_s: Option<[f64; 2]>,
    /// Statistic of all that was measured; each quantity has one of its own where absent.
    pub take: Option<ExpectedStatistic>,
    /// Least value of the statistic.
    pub least: Option<f64>,
    /// Greatest value of the statistic.
    pub most: Option<f64>,
}

/// Quantity of an expectation. Expressions are about `me`, and evaluated ten times a simulated second. A
/// new one may need arms in `statistic`, `bounds` and `finish` of the measuring expectations, of which the compiler says nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ExpectedQuantity {
    /// Share of each agent's time in which a predicate holds (`min`, at least 1).
    Always(String),
    /// Share of each agent's time in which a predicate does not hold (`min`, at least 1).
    Never(String),
    /// Time until each agent has met all of these predicates in their order: from the first one, or from its entry where there is one
    /// (s). It is infinite where the agent never meets them, or a later one before an earlier one (`share`, at least 1).
    Passes(Vec<String>),
    /// Duration of each spell in which a predicate holds for an agent (s, `p90`).
    Lasts(String),
    /// Value of an expression for each agent at each time (`mean`).
    Amount(String),
    /// Speed at which the news of an event have come to each agent that was told, from the agents that saw it happen, where these are 5 m away
    /// or farther (m/s, `p95`).
    News(String),
    /// Whether the first in line was let in first: 1 or 0 for each two agents of whom one stood in this queue over a second before the
    /// other (`mean`, at least 1).
    Queue(String),
    /// Time from joining a line of a service until service begins, of each agent that was served, and so far of those that still wait
    /// (s, `p90`).
    Wait(String),
    /// Whether an action is mutual: 1 where the other agent does the same with this one within a second, and both face each other
    /// within 15 degrees; else 0 (`mean`, at least 1).
    Mutual(String),
    /// Figure of `throng run --json`, of all or of one group; `services.NAME.KEY` and `sources.GROUP.KEY` are those of its `statistics`.
    Figure(String),
}

/// Statistic of an expectation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ExpectedStatistic {
    /// Least value.
    Min,
    /// 10th percentile.
    P10,
    /// Median.
    Median,
    /// Mean.
    Mean,
    /// 90th percentile.
    P90,
    /// 95th percentile.
    P95,
    /// Greatest value.
    Max,
    /// Share of the values that are finite.
    Share,
}

impl ExpectConfig {
    /// Statistic that is taken.
    pub fn statistic(&self) -> ExpectedStatistic {
        self.take.unwrap_or(match self.that {
            ExpectedQuantity::Always(_) | ExpectedQuantity::Never(_) => ExpectedStatistic::Min,
            ExpectedQuantity::Passes(_) => ExpectedStatistic::Share,
            ExpectedQuantity::Lasts(_) | ExpectedQuantity::Wait(_) => ExpectedStatistic::P90,
            ExpectedQuantity::News(_) => ExpectedStatistic::P95,
            _ => ExpectedStatistic::Mean,
        })
    }

    /// Least and greatest value of the statistic.
    pub fn bounds(&self) -> [f64; 2] {
        let is_whole = matches!(
            self.that,
            ExpectedQuantity::Always(_)
                | ExpectedQuantity::Never(_)
                | ExpectedQuantity::Passes(_)
                | ExpectedQuantity::Queue(_)
                | ExpectedQuantity::Mutual(_)
        );
        let least = if is_whole && self.take.is_none() && self.most.is_none() { 1.0 } else { f64::NEG_INFINITY };
        [self.least.unwrap_or(least), self.most.unwrap_or(f64::INFINITY)]
    }

    pub(super) fn find_fault(&self, key: &str) -> Result<(), KeyFault> {
        let [least, most] = self.bounds();
        if least == f64::NEG_INFINITY && most == f64::INFINITY {
            return key_fault(key, "expected `least` or `most`, found neither");
        }
        if least > most {
            return key_fault(&format!("{key}.most"), format!("expected at least {least}, found {most}"));
        }
        for (name, bound) in [("least", self.least), ("most", self.most)] {
            check_numbers(&[(&format!("{key}.{name}"), bound.unwrap_or(0.0), -1e9, 1e9)])?;
        }
        if let Some([from, to]) = self.between_s
            && !(0.0 <= from && from <= to)
        {
            let why = format!("expected two times that ascend from 0, found {from} and {to}");
            return key_fault(&format!("{key}.between_s"), why);
        }
        match &self.that {
            ExpectedQuantity::Passes(all) if all.is_empty() => {
                key_fault(&format!("{key}.that.passes"), "expected predicates, found none")
            }
            ExpectedQuantity::Figure(_) if self.take.is_some() || self.between_s.is_some() || self.who.len() > 1 => {
                key_fault(
                    key,
                    "a figure is one number of a run: expected no `take`, no `between_s`, and at most one group",
                )
            }
            _ => Ok(()),
        }
    }
}
