//! Which rules keep tasks from starting, so that a message can name the one to change.

use std::fmt;

/// A rule that a place must keep to be a start or a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// The disc about it lies in the world.
    Edge,
    /// No obstacle is near.
    Obstacles,
    /// The ground is level.
    Tilt,
    /// The ground is even.
    Unevenness,
    /// A start isn't steeply uphill.
    Climb,
    /// A vehicle at a start stands on all wheels.
    Twist,
    /// A vehicle at a start doesn't slide.
    Grip,
}

impl Rule {
    const ALL: [Self; 7] =
        [Self::Edge, Self::Obstacles, Self::Tilt, Self::Unevenness, Self::Climb, Self::Twist, Self::Grip];

    /// What makes it easier to keep, in the words of the rules.
    fn remedy(self, fields: Fields) -> String {
        let Fields { stand, distance, .. } = fields;
        match self {
            Self::Edge => {
                format!("lower {distance} or {stand}.reach, because positions exceed the edge of the world")
            }
            Self::Obstacles => "reduce the obstacle density".to_owned(),
            Self::Tilt => format!("raise {stand}.tilt"),
            Self::Unevenness => format!("raise {stand}.unevenness"),
            Self::Climb => format!("raise {stand}.climb"),
            Self::Twist => format!("raise {stand}.twist"),
            Self::Grip => format!("raise {stand}.grip"),
        }
    }
}

/// What a file of rules calls what surfaces follow from, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fields {
    /// Nodes and the distance between them.
    pub(crate) grid: &'static str,
    /// The ground at starts and goals.
    pub(crate) stand: &'static str,
    /// The distance between starts and goals, or half of it.
    pub(crate) distance: &'static str,
    /// What else can be done if there is no start, as the end of a sentence.
    pub(crate) elsewhere: &'static str,
}

/// How many places were looked at, and how many of them broke each rule.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    places: u64,
    broken: [u64; Rule::ALL.len()],
}

impl Tally {
    /// Takes the rules that a place breaks.
    pub(crate) fn add(&mut self, rules: &[Rule]) {
        self.places += 1;
        rules.iter().for_each(|rule| self.broken[*rule as usize] += 1);
    }

    fn join(&mut self, other: &Self) {
        self.places += other.places;
        self.broken.iter_mut().zip(other.broken).for_each(|(own, other)| *own += other);
    }

    /// The share of the places that break a rule.
    fn share(&self, rule: Rule) -> f64 {
        self.broken[rule as usize] as f64 / self.places.max(1) as f64
    }
}

/// How often the rules of starts and goals were broken.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Broken {
    /// At all places of starts and goals.
    pub(crate) stands: Tally,
    /// At the starts whose places, and those of their goals, keep the former.
    pub(crate) starts: Tally,
}

impl Broken {
    pub(crate) fn join(&mut self, other: &Self) {
        self.stands.join(&other.stands);
        self.starts.join(&other.starts);
    }

    /// The rule that is broken most often, with its share of the places that could break it.
    fn worst(&self) -> (Rule, f64) {
        let share = |rule| self.stands.share(rule).max(self.starts.share(rule));
        // Of equals the first.
        let worst = Rule::ALL.into_iter().rev().max_by(|a, b| share(*a).total_cmp(&share(*b)));
        let rule = worst.unwrap_or(Rule::Tilt);
        (rule, share(rule))
    }
}

/// Why tasks found no start and no goal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoStarts {
    text: String,
}

impl NoStarts {
    /// Of so many tasks that were wanted; on the ground that had most room so many could start.
    pub(crate) fn new(tasks: usize, room: usize, broken: &Broken, fields: Fields) -> Self {
        let (rule, share) = broken.worst();
        let room = match room {
            0 => String::new(),
            // They may have room on one side alone.
            _ => format!("there is room for at most {room} of {tasks} tasks: lower tasks.count, or "),
        };
        let share = (100.0 * share).round();
        let (remedy, elsewhere) = (rule.remedy(fields), fields.elsewhere);
        Self { text: format!("{room}{remedy} ({share} % of the positions violate this rule){elsewhere}") }
    }
}

impl fmt::Display for NoStarts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
