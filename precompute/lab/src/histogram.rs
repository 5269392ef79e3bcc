//! A histogram of non-negative values.

/// Counts of non-negative values in bins, `PER_UNIT` to a unit; values beyond the last bin count in the last.
#[derive(Clone, Debug, Default)]
pub(crate) struct Histogram<const PER_UNIT: u32, const BINS: usize> {
    counts: Vec<u64>,
    sum: f64,
    /// Number of values.
    pub num: u64,
    pub max: f64,
}

impl<const PER_UNIT: u32, const BINS: usize> Histogram<PER_UNIT, BINS> {
    pub fn add(&mut self, value: f32) {
        let bin = ((value * PER_UNIT as f32) as usize).min(BINS - 1);
        if self.counts.len() <= bin {
            self.counts.resize(bin + 1, 0);
        }
        self.counts[bin] += 1;
        (self.sum, self.num, self.max) = (self.sum + f64::from(value), self.num + 1, self.max.max(f64::from(value)));
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.num.max(1) as f64
    }

    /// Quantile of the values, as the upper end of its bin; 0 without values.
    pub fn quantile(&self, share: f64) -> f64 {
        self.bin(share).map_or(0.0, |bin| (bin + 1) as f64 / f64::from(PER_UNIT)).min(self.max)
    }

    /// Quantile of the values, as the middle of its bin; 0 without values.
    pub fn middle_quantile(&self, share: f64) -> f64 {
        self.bin(share).map_or(0.0, |bin| (bin as f64 + 0.5) / f64::from(PER_UNIT))
    }

    fn bin(&self, share: f64) -> Option<usize> {
        let mut left = (self.num as f64 * share).ceil() as u64;
        self.counts.iter().position(|n| {
            left = left.saturating_sub(*n);
            left == 0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_values() {
        let mut values = Histogram::<50, 4000>::default();
        (1..=1000).for_each(|i| values.add(i as f32 * 0.01));
        assert!((values.quantile(0.5) - 5.0).abs() < 0.03, "{}", values.quantile(0.5));
        assert_eq!((values.quantile(1.0), values.max, values.num), (10.0, 10.0, 1000));
        let none = Histogram::<50, 4000>::default();
        assert_eq!((none.quantile(0.5), none.middle_quantile(0.5), none.mean()), (0.0, 0.0, 0.0));
        let mut few = Histogram::<1000, 100>::default();
        (0..100).for_each(|i| few.add(if i < 95 { 0.0105 } else { 0.0505 }));
        assert_eq!([0.95, 0.96].map(|share| few.middle_quantile(share)), [0.0105, 0.0505]);
    }
}
