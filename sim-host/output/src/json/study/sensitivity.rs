//! What a weld's figures depend on.

use crate::StudySensitivityReport;
use crate::json::result;
use trueweld_evaluate::Figure;
use trueweld_evaluate::study::{Derivative, Input, SobolIndex, WithInterval};
use trueweld_plant::provenance::Provenance;

result! {
    /// Derivatives and Sobol indices of a weld's figures by what is not known of a cell.
    StudySensitivityResult<'a> of (report: &StudySensitivityReport<'a>) with {
        let global = report.global;
        let asked = report.study.figures();
        let figures = asked.map(|figure| SensitivityFigure::of(figure, report));
    } {
        /// What the result is of.
        provenance: &'a Provenance = report.provenance,
        /// Length that was welded, m.
        length_m: f64 = report.length,
        /// Seed of the design.
        seed: u64 = report.study.seed,
        /// Rows of the design that count.
        rows: usize = global.rows,
        /// Rows left out since one of their runs came to no end.
        rows_dropped: usize = global.dropped,
        /// Runs of the design.
        runs: usize = report.runs.len(),
        /// Inputs of the indices.
        inputs: Vec<StudyInput<'a>> = global.inputs.iter().map(StudyInput::of).collect(),
        /// Figure by figure.
        figures: Vec<SensitivityFigure<'a>> =
            figures.filter(|of| of.middle.is_some() || of.mean.is_some()).collect(),
    }
}

result! {
    /// An input of the indices.
    StudyInput<'a> of (input: &'a Input) {
        /// Its name.
        name: &'a str = &input.name,
        /// How many numbers it moves together.
        numbers: usize = input.count(),
    }
}

result! {
    /// What one figure depends on.
    SensitivityFigure<'a> of (of: &'static Figure, report: &StudySensitivityReport<'a>) with {
        let global = report.global.figures.iter().find(|f| f.figure.key == of.key);
        let local = report.local.figures.iter().find(|f| f.figure.key == of.key);
        let ranked = report.ranked(of.key).into_iter();
        let slopes = report.derivatives(of.key).into_iter();
    } {
        /// Its key, the unit at its end.
        figure: &'static Figure = of,
        /// Its value in the cell in the middle of what is not known.
        middle: Option<f64> = local.map(|f| f.value),
        /// Its mean over the cells.
        mean: Option<f64> = global.map(|f| f.mean),
        /// Its standard deviation over the cells.
        standard_deviation: Option<f64> = global.map(|f| f.deviation),
        /// Indices, the largest total first.
        indices: Vec<InputIndices<'a>> =
            ranked.map(|(input, index)| InputIndices::of(input, index)).collect(),
        /// Derivatives, the largest first.
        derivatives: Vec<InputDerivative<'a>> =
            slopes.map(|(input, slope)| InputDerivative::of(input, slope)).collect(),
    }
}

result! {
    /// The indices of one input.
    InputIndices<'a> of (name: &'a str, index: SobolIndex) {
        /// The input.
        input: &'a str = name,
        /// Share of the variance that the input makes by itself.
        first: WithInterval = index.first,
        /// Share that it makes with all others.
        total: WithInterval = index.total,
    }
}

result! {
    /// The derivative by one input.
    InputDerivative<'a> of (name: &'a str, slope: Option<Derivative>) {
        /// The input.
        input: &'a str = name,
        /// Per standard deviation of the input, in the figure's unit; `null` where a run came to no end.
        derivative: Option<Derivative> = slope,
    }
}
