//! The results that the paper's authors published.
//!
//! Success, rollovers and stuck trials of all tasks: Table I of Xu et al., "Verti-Bench", RSS 2025. The rest is read off the bars of
//! `plot.ipynb` in their repository (±0.3 of success, ±0.2 s, ±0.2°). Their worlds are others than ours, and their vehicle is
//! `hmmwv-released`.

/// Published results of a planner: percentages of all tasks, and figures per level of relief, low to high.
pub(super) struct Published {
    pub(super) plugin: &'static str,
    pub(super) success: f64,
    pub(super) rollover: f64,
    pub(super) stuck: f64,
    pub(super) levels: [Level; 3],
}

/// Success, %; mean time of successful trials, s; means of |roll| and |pitch|, degrees.
pub(super) struct Level {
    pub(super) success: f64,
    pub(super) time: f64,
    pub(super) roll: f64,
    pub(super) pitch: f64,
}

const fn level(success: f64, time: f64, roll: f64, pitch: f64) -> Level {
    Level { success, time, roll, pitch }
}

const PUBLISHED: &[Published] = &[
    Published {
        plugin: "pid",
        success: 48.8,
        rollover: 14.7,
        stuck: 36.5,
        levels: [level(85.9, 23.2, 2.4, 2.2), level(50.4, 25.4, 5.2, 4.2), level(7.9, 24.5, 11.1, 7.6)],
    },
    Published {
        plugin: "eh",
        success: 44.3,
        rollover: 16.3,
        stuck: 39.4,
        levels: [level(67.3, 26.0, 2.4, 2.2), level(48.5, 29.8, 5.4, 4.2), level(16.7, 30.0, 11.7, 7.4)],
    },
    Published {
        plugin: "mppi",
        success: 41.2,
        rollover: 17.9,
        stuck: 40.9,
        levels: [level(62.1, 22.3, 2.6, 2.5), level(47.8, 27.8, 7.8, 5.2), level(12.8, 27.9, 17.9, 10.0)],
    },
];

/// Returns the published results of a plugin's planner.
pub(super) fn of(plugin: &str) -> Option<&'static Published> {
    PUBLISHED.iter().find(|p| p.plugin == plugin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trial_ends_in_one_way_and_levels_make_up_the_whole() {
        for p in PUBLISHED {
            assert!((p.success + p.rollover + p.stuck - 100.0).abs() < 0.11, "{}", p.plugin);
            // Of the 1000 tasks 340 are low, 330 medium and 330 high.
            let [low, medium, high] = [0, 1, 2].map(|i| p.levels[i].success);
            let all = 0.34 * low + 0.33 * medium + 0.33 * high;
            assert!((all - p.success).abs() < 0.4, "{}: {all}", p.plugin);
        }
    }
}
