//! Published responses to a step of 11 kN, set beside ours: Bres et al., "Simulation of robotic
//! friction stir welding of aerospace components", Industrial Robot 37(1), 2010.

/// What the paper states of one control scheme.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PublishedStep {
    /// Our name of the controller.
    pub controller: &'static str,
    /// The paper's number of the scheme.
    pub scheme: u8,
    /// Time to 5 %, s: after it the response stays within 5 % (for scheme 3, whose overshoot is
    /// below 5 %, it is also the first entry).
    pub settle: f64,
    /// Overshoot over the step's height.
    pub overshoot: f64,
    /// Static error, in words.
    pub static_error: &'static str,
    /// Spindle ripple, in words.
    pub ripple: &'static str,
}

const SCHEMES: [PublishedStep; 3] = [
    PublishedStep {
        controller: "parallel",
        scheme: 1,
        settle: 0.370,
        overshoot: 0.24,
        static_error: "≈ 0 N",
        ripple: "–",
    },
    PublishedStep {
        controller: "superposed",
        scheme: 2,
        settle: 0.580,
        overshoot: 0.20,
        static_error: "≈ 200 N",
        ripple: "damped",
    },
    PublishedStep {
        controller: "external",
        scheme: 3,
        settle: 0.860,
        overshoot: 0.045,
        static_error: "0 N",
        ripple: "≤ 50 N",
    },
];

impl PublishedStep {
    /// What is published of the controller of this name.
    pub(crate) fn of(controller: &str) -> Option<&'static Self> {
        SCHEMES.iter().find(|s| s.controller == controller)
    }
}
