//! Colours, the same in every output: one a run, one a joint (Okabe and Ito's set, told apart by
//! the colour-blind).

/// Red, green, blue.
pub(crate) type Rgb = [u8; 3];

/// The desired value, limits, and what belongs to no run.
pub(crate) const REFERENCE: Rgb = [110, 110, 110];

/// What must not be exceeded.
pub(crate) const LIMIT: Rgb = [0, 140, 100];

/// None of them green, which limits are.
const RUN_COLOURS: [Rgb; 7] = [
    [213, 94, 0],
    [0, 114, 178],
    [204, 121, 167],
    [190, 160, 0],
    [120, 90, 40],
    [86, 180, 233],
    [30, 30, 30],
];

/// Axes A1 to A6.
pub(crate) const JOINT_COLOURS: [Rgb; 6] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [190, 160, 0], [86, 180, 233]];

/// How a line is drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Dash {
    #[default]
    Solid,
    Dashed,
    Dotted,
}

impl Dash {
    /// Pixels drawn and left out, over and over.
    pub(crate) fn pixels(self) -> Option<[u32; 2]> {
        match self {
            Self::Solid => None,
            Self::Dashed => Some([6, 4]),
            Self::Dotted => Some([2, 3]),
        }
    }

    /// Its name in CSS.
    pub(crate) fn name(self) -> Option<&'static str> {
        match self {
            Self::Solid => None,
            Self::Dashed => Some("dashed"),
            Self::Dotted => Some("dotted"),
        }
    }
}

/// Of one of many lines: the colours of the runs, solid, then dashed, then dotted.
pub(crate) fn series(index: usize) -> (Rgb, Dash) {
    let dashes = [Dash::Solid, Dash::Dashed, Dash::Dotted];
    (run(index), dashes[index / RUN_COLOURS.len() % dashes.len()])
}

/// Of the run at this place.
pub(crate) fn run(index: usize) -> Rgb {
    RUN_COLOURS[index % RUN_COLOURS.len()]
}

/// Its name, for words beside a picture.
#[cfg(feature = "rerun")]
pub(crate) fn run_in_words(index: usize) -> &'static str {
    ["orange", "blue", "pink", "yellow", "brown", "light blue", "black"][index % RUN_COLOURS.len()]
}

/// As CSS writes it.
pub(crate) fn css([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
