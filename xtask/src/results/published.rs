//! The results that the paper's authors published.
//!
//! Success, rollovers and stuck trials of all tasks: Table I of Xu et al., "Verti-Bench", RSS 2025. The rest is read off the bars of
//! `plot.ipynb` in their repository (±0.3 of success, ±0.2 s, ±0.2°). Those bars show RL, MCL and ACL as they were before the runs of
//! the table, and are left out. Their worlds are others than ours, and their vehicle is `hmmwv-released`.

/// Published results of a planner: percentages of all tasks, and figures per level of relief, low to high, where they were published.
pub(super) struct Published {
    pub(super) plugin: &'static str,
    pub(super) success: f64,
    pub(super) rollover: f64,
    pub(super) stuck: f64,
    pub(super) levels: Option<[Level; 3]>,
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
        levels: Some([level(85.9, 23.2, 2.4, 2.2), level(50.4, 25.4, 5.2, 4.2), level(7.9, 24.5, 11.1, 7.6)]),
    },
    Published {
        plugin: "eh",
        success: 44.3,
        rollover: 16.3,
        stuck: 39.4,
        levels: Some([
            level(67.3, 26.0, 2.4, 2.2),
            level(48.5, 29.8, 5.4, 4.2),
            level(16.7, 30.0, 11.7, 7.4),
        ]),
    },
    Published {
        plugin: "mppi",
        success: 41.2,
        rollover: 17.9,
        stuck: 40.9,
        levels: Some([
            level(62.1, 22.3, 2.6, 2.5),
            level(47.8, 27.8, 7.8, 5.2),
            level(12.8, 27.9, 17.9, 10.0),
        ]),
    },
    Published { plugin: "rl", success: 10.0, rollover: 14.3, stuck: 75.7, levels: None },
    Published { plugin: "mcl", success: 41.8, rollover: 16.9, stuck: 41.3, levels: None },
    Published { plugin: "acl", success: 36.6, rollover: 15.4, stuck: 48.0, levels: None },
    Published {
        plugin: "wmvct",
        success: 41.5,
        rollover: 18.9,
        stuck: 39.6,
        levels: Some([
            level(65.5, 22.9, 2.5, 2.5),
            level(46.2, 28.2, 7.6, 5.1),
            level(12.1, 30.0, 18.2, 9.7),
        ]),
    },
    Published {
        plugin: "mppi6",
        success: 47.0,
        rollover: 18.0,
        stuck: 35.0,
        levels: Some([
            level(71.2, 23.6, 2.8, 2.4),
            level(53.8, 28.5, 9.6, 5.3),
            level(14.3, 28.2, 17.5, 9.8),
        ]),
    },
    Published {
        plugin: "tal",
        success: 58.4,
        rollover: 17.0,
        stuck: 24.6,
        levels: Some([
            level(91.8, 23.4, 2.5, 2.3),
            level(64.8, 30.0, 5.3, 4.1),
            level(17.6, 29.7, 11.3, 7.9),
        ]),
    },
    Published {
        plugin: "tnt",
        success: 57.4,
        rollover: 17.5,
        stuck: 25.1,
        levels: Some([
            level(89.4, 23.8, 2.5, 2.3),
            level(63.7, 30.3, 5.4, 4.1),
            level(17.3, 29.3, 11.8, 8.2),
        ]),
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
            let Some(levels) = &p.levels else { continue };
            let [low, medium, high] = [0, 1, 2].map(|i| levels[i].success);
            let all = 0.34 * low + 0.33 * medium + 0.33 * high;
            assert!((all - p.success).abs() < 0.4, "{}: {all}", p.plugin);
        }
    }
}
