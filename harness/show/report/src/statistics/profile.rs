//! How often a planner is within a factor of the best.

/// A planner's performance profile (Dolan and Moré 2002): for a factor τ the share of tasks that it solves within τ times
/// the least cost of any planner.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// (τ, share) where the share rises, τ ascending from 1.
    pub steps: Vec<[f64; 2]>,
}

impl Profile {
    /// Share of tasks solved within `factor` times the least cost.
    #[must_use]
    pub fn at(&self, factor: f64) -> f64 {
        self.steps.iter().take_while(|s| s[0] <= factor).last().map_or(0.0, |s| s[1])
    }
}

/// Profiles of planners from their costs: `costs[planner][task]`, positive, none where the planner failed. All planners
/// have the same tasks. A task that nobody solves counts for nobody.
#[must_use]
pub fn profiles(costs: &[Vec<Option<f64>>]) -> Vec<Profile> {
    let tasks = costs.first().map_or(0, Vec::len);
    let best: Vec<f64> =
        (0..tasks).map(|t| costs.iter().filter_map(|c| c[t]).fold(f64::INFINITY, f64::min)).collect();
    let of = |own: &Vec<Option<f64>>| {
        let mut ratios: Vec<f64> = own.iter().zip(&best).filter_map(|(c, b)| Some((*c)? / b)).collect();
        ratios.sort_by(f64::total_cmp);
        let mut steps: Vec<[f64; 2]> = Vec::new();
        for (k, &ratio) in ratios.iter().enumerate() {
            let fraction = (k + 1) as f64 / tasks as f64;
            match steps.last_mut() {
                Some(last) if last[0] == ratio => last[1] = fraction,
                _ => steps.push([ratio, fraction]),
            }
        }
        Profile { steps }
    };
    costs.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_starts_at_the_share_of_wins_and_ends_at_the_share_solved() {
        // By the definition in Dolan and Moré 2002, section 2: four tasks, of which nobody solves the last.
        let a = vec![Some(10.0), Some(20.0), None, None];
        let b = vec![Some(20.0), Some(20.0), Some(5.0), None];
        let p = profiles(&[a, b]);
        assert_eq!((p[0].at(1.0), p[1].at(1.0)), (0.5, 0.5));
        assert_eq!((p[1].at(1.99), p[1].at(2.0)), (0.5, 0.75));
        assert_eq!(p[0].at(1e9), 0.5);
        assert_eq!(p[0].at(0.99), 0.0);
        assert!(profiles(&[]).is_empty());
    }
}
