//! Search for the relief at which a given fraction of tasks is completed.
//!
//! The fraction falls with the relief, but for the noise of some hundred tasks. Over the logarithm of the relief, its logit is nearly a straight
//! line, so that few evaluations are needed: the next relief is where the line through the two nearest ones meets the target.

/// Slope of the logit of the completed fraction over the logarithm of the relief that is assumed until two evaluations show one: that of PID in a
/// HMMWV between factors of 1 and 1.8 (5 on medium, 6 to 10 on high).
const SLOPE: f64 = -6.0;
/// Gentlest slope that two evaluations are believed to show: less is noise.
const GENTLEST: f64 = -2.0;
/// Longest step of the logarithm of the relief beyond what was evaluated.
const STEP: f64 = 0.5;
/// Shortest of these steps: noise of a hundred tasks is as much.
const LEAST: f64 = 0.03;
/// Least and greatest factor.
pub const FACTORS: [f64; 2] = [0.2, 5.0];

/// What was found at a relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// Factor on the relief.
    pub factor: f64,
    pub completed: usize,
    pub tasks: usize,
}

impl Evaluation {
    /// Fraction of completed tasks.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        self.completed as f64 / self.tasks.max(1) as f64
    }

    /// Logit of the fraction, as if half a task more were completed and half a task more were not, so that it is finite.
    fn logit(&self) -> f64 {
        let done = self.completed as f64 + 0.5;
        vb_math::ln(done / (self.tasks as f64 + 1.0 - done))
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    target: f64,
    tolerance: f64,
    most: usize,
    done: Vec<Evaluation>,
}

impl Search {
    /// A search for the factor at which this fraction of tasks is completed, which ends once a fraction is as near to it as the tolerance, or
    /// after so many evaluations.
    #[must_use]
    pub fn new(target: f64, tolerance: f64, most: usize) -> Self {
        Self { target, tolerance, most, done: Vec::new() }
    }

    pub fn add(&mut self, evaluation: Evaluation) {
        self.done.push(evaluation);
    }

    /// All evaluations in order.
    #[must_use]
    pub fn done(&self) -> &[Evaluation] {
        &self.done
    }

    /// The evaluation whose fraction is nearest to the target, the first of equals.
    #[must_use]
    pub fn best(&self) -> Option<&Evaluation> {
        let off = |e: &&Evaluation| (e.fraction() - self.target).abs();
        self.done.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The next factor to try, with three decimals; `None` once the search has ended.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        let Some(best) = self.best() else { return Some(1.0) };
        if self.done.len() >= self.most || (best.fraction() - self.target).abs() <= self.tolerance {
            return None;
        }
        let wanted = vb_math::ln(self.target / (1.0 - self.target));
        let x = |e: &Evaluation| vb_math::ln(e.factor);
        // The nearest from above the target and the nearest from below: of these the line, where both are there.
        let side = |above: bool| {
            let of = self.done.iter().filter(move |e| (e.fraction() > self.target) == above);
            let off = |e: &&Evaluation| (e.fraction() - self.target).abs();
            of.min_by(|a, b| off(a).total_cmp(&off(b)))
        };
        let at = match (side(true), side(false)) {
            (Some(a), Some(b)) => {
                let slope = ((b.logit() - a.logit()) / (x(b) - x(a))).min(GENTLEST);
                let slope = if slope.is_finite() { slope } else { SLOPE };
                let (near, far) = if best == a { (a, b) } else { (b, a) };
                let at = x(near) + (wanted - near.logit()) / slope;
                // Never beyond what was evaluated, and not on it again.
                let (low, high) = (x(near).min(x(far)), x(near).max(x(far)));
                let margin = 0.1 * (high - low);
                if margin > 0.0 { at.clamp(low + margin, high - margin) } else { at }
            }
            // All on one side: on from the farthest, since several may be as near (no task, or each, was completed).
            (Some(_), None) => {
                let last = self.done.iter().max_by(|a, b| a.factor.total_cmp(&b.factor)).unwrap_or(best);
                x(last) + ((wanted - last.logit()) / SLOPE).clamp(LEAST, STEP)
            }
            _ => {
                let last = self.done.iter().min_by(|a, b| a.factor.total_cmp(&b.factor)).unwrap_or(best);
                x(last) + ((wanted - last.logit()) / SLOPE).clamp(-STEP, -LEAST)
            }
        };
        let next = (vb_math::exp(at).clamp(FACTORS[0], FACTORS[1]) * 1000.0).round() / 1000.0;
        // A factor that was evaluated gives the same again.
        (!self.done.iter().any(|e| e.factor == next)).then_some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches where the logit of the completed fraction falls along a line, with so many tasks.
    fn search(target: f64, middle: f64, slope: f64, tasks: usize) -> Search {
        let mut search = Search::new(target, 0.015, 8);
        while let Some(factor) = search.next() {
            let logit = slope * vb_math::ln(factor / middle);
            let completed = (tasks as f64 / (1.0 + vb_math::exp(-logit))).round() as usize;
            search.add(Evaluation { factor, completed, tasks });
        }
        search
    }

    #[test]
    fn the_factor_is_found_in_few_evaluations_whatever_the_slope() {
        for target in [0.86, 0.5, 0.08] {
            for middle in [0.5, 1.0, 1.8, 2.5] {
                for slope in [-4.0, -6.0, -10.0] {
                    let search = search(target, middle, slope, 300);
                    let best = search.best().unwrap();
                    assert!(
                        (best.fraction() - target).abs() <= 0.02,
                        "{target} {middle} {slope}: {search:?}"
                    );
                    assert!(search.done().len() <= 8, "{search:?}");
                }
            }
        }
    }

    #[test]
    fn a_search_ends_when_nothing_helps() {
        // All tasks are completed at any relief: it goes to the greatest factor and no farther.
        let mut search = Search::new(0.5, 0.01, 20);
        while let Some(factor) = search.next() {
            search.add(Evaluation { factor, completed: 100, tasks: 100 });
        }
        assert!(search.done().len() < 20 && search.done().iter().any(|e| e.factor == 5.0), "{search:?}");
        // Noise that rises with the relief.
        let mut search = Search::new(0.5, 0.01, 6);
        let mut completed = [40, 60, 45, 55, 40, 60].into_iter();
        while let Some(factor) = search.next() {
            search.add(Evaluation { factor, completed: completed.next().unwrap(), tasks: 100 });
        }
        assert!((3..=6).contains(&search.done().len()), "{search:?}");
    }
}
