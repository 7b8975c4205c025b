//! Statistics of columns, by which learners normalise.

use serde::{Deserialize, Serialize};

use crate::feature::{Feature, Values};

/// The statistics of a column over some frames: one entry for each entry of a vector; one for all cells of a grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stats {
    pub(crate) min: Vec<f64>,
    pub(crate) max: Vec<f64>,
    pub(crate) mean: Vec<f64>,
    /// Standard deviations, those of the population.
    pub(crate) std: Vec<f64>,
    /// The number of frames.
    pub(crate) count: [u64; 1],
}

impl Stats {
    /// The statistics over these values of a feature; zeros where there are none.
    pub(crate) fn of(feature: &Feature, values: &Values) -> Self {
        let width = if feature.is_grid() { 1 } else { feature.width() };
        let frames = values.len() / feature.width().max(1);
        let mut stats = Self { count: [frames as u64], ..Self::default() };
        for k in 0..width {
            let own = Self::of_numbers((k..values.len()).step_by(width).map(|i| values.number(i)));
            stats.push(own.min[0], own.max[0], own.mean[0], own.std[0]);
        }
        stats
    }

    /// The statistics over these numbers, one of each frame; zeros where there are none.
    pub(crate) fn of_numbers(numbers: impl Iterator<Item = f64> + Clone) -> Self {
        let count = numbers.clone().count();
        let mut stats = Self { count: [count as u64], ..Self::default() };
        if count == 0 {
            stats.push(0.0, 0.0, 0.0, 0.0);
            return stats;
        }
        let mean = numbers.clone().sum::<f64>() / count as f64;
        let variance = numbers.clone().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count as f64;
        let min = numbers.clone().fold(f64::INFINITY, f64::min);
        let max = numbers.fold(f64::NEG_INFINITY, f64::max);
        stats.push(min, max, mean, variance.sqrt());
        stats
    }

    fn push(&mut self, min: f64, max: f64, mean: f64, std: f64) {
        self.min.push(min);
        self.max.push(max);
        self.mean.push(mean);
        self.std.push(std);
    }
}

/// The statistics over all frames, from those of parts.
pub(crate) fn pooled<'a>(parts: impl Iterator<Item = &'a Stats> + Clone) -> Stats {
    let total: u64 = parts.clone().map(|p| p.count[0]).sum();
    let parts = parts.filter(|p| p.count[0] > 0);
    let width = parts.clone().map(|p| p.mean.len()).min().unwrap_or(0);
    let mut all = Stats { count: [total], ..Stats::default() };
    for k in 0..width {
        let weighted = |f: &dyn Fn(&Stats) -> f64| {
            parts.clone().map(|p| p.count[0] as f64 * f(p)).sum::<f64>() / total as f64
        };
        let mean = weighted(&|p| p.mean[k]);
        let variance = weighted(&|p| p.std[k] * p.std[k] + (p.mean[k] - mean) * (p.mean[k] - mean));
        let min = parts.clone().map(|p| p.min[k]).fold(f64::INFINITY, f64::min);
        let max = parts.clone().map(|p| p.max[k]).fold(f64::NEG_INFINITY, f64::max);
        all.push(min, max, mean, variance.sqrt());
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feature::Layout;

    #[test]
    fn parts_pool_to_the_whole() {
        let layout = Layout { wheels: 4, speed: true, goal: false, truth: false, crops: 0 };
        let feature = layout.features().into_iter().find(|f| f.name == "action.speed").unwrap();
        let values: Vec<f32> = (0..100).map(|k| (k * k % 37) as f32).collect();
        let of = |v: &[f32]| Stats::of(&feature, &Values::F32(v.to_vec()));
        let whole = of(&values);
        let parts = [of(&values[..13]), of(&[]), of(&values[13..])];
        let sum = pooled(parts.iter());
        assert_eq!((sum.count, &sum.min, &sum.max), (whole.count, &whole.min, &whole.max));
        assert!((sum.mean[0] - whole.mean[0]).abs() < 1e-12 && (sum.std[0] - whole.std[0]).abs() < 1e-12);
        // 0, 2: mean 1, standard deviation 1.
        let two = of(&[0.0, 2.0]);
        assert_eq!((two.mean[0], two.std[0], two.count), (1.0, 1.0, [2]));
    }
}
