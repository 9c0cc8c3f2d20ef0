//! Expressions over named numbers: how a model file states an effect of the user's own.
//!
//! ```text
//! sum      = product { (+|-) product }          product = signed { (*|/) signed }
//! signed   = { +|- } power                      power   = value [ ^ signed ]
//! value    = number | name | function( sum [, sum] ) | ( sum )
//! ```
//!
//! One [`Loop`] may stand in an expression, `dahl(variable, width)` or `play(variable, width)`: what
//! it remembers comes with the variables, and its width is made of numbers and parameters alone.
//!
//! An expression may have a table beside it: `table( sum )` is then the straight line between its
//! values at places on either side, and the nearest of them beyond its ends; `table( sum, sum )` of one
//! over two variables is straight along each of them.
//!
//! As in print: −x² is −(x²), and a^b^c is a^(b^c). A text becomes a list of operations on a small
//! stack, so that evaluating neither allocates nor fails; where the mathematics has no answer the
//! value is not finite. Left out: conditions, for which `step` does.

use super::memory::{LOOP_NAMES, Loop};
use super::table::Places;
use crate::input::nearest;
use std::ops::Range;

/// Values that an evaluation may hold at once, and parentheses that may stand inside one another.
const EXPRESSION_DEPTH_MAX: usize = 32;

/// Numbers, names and operators that one expression may have: it is evaluated at every step.
const MOST_OPERATIONS: usize = 1000;

type Function = fn(f64) -> f64;
type FunctionOfTwo = fn(f64, f64) -> f64;

/// Functions of one number.
const FUNCTIONS: &[(&str, Function)] = &[
    ("abs", f64::abs),
    ("sign", sign),
    ("step", step),
    ("sqrt", f64::sqrt),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("floor", f64::floor),
];

/// Functions of two numbers.
const FUNCTIONS_OF_TWO: &[(&str, FunctionOfTwo)] =
    &[("min", min), ("max", max), ("atan2", f64::atan2)];

/// −1, 0 or 1; what is not a number stays so.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// 1 above 0, else 0; what is not a number stays so.
fn step(x: f64) -> f64 {
    if x.is_nan() { x } else { f64::from(u8::from(x > 0.0)) }
}

// The standard library's forget an operand that is not a number; a mistake must not vanish in them.
fn min(a: f64, b: f64) -> f64 {
    if a < b || a.is_nan() { a } else { b }
}

fn max(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

#[derive(Debug, Clone, Copy)]
enum Operation {
    Number(f64),
    Variable(usize),
    Parameter(usize),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Table,
    /// The table over two variables.
    Surface,
    Of(Function),
    OfTwo(FunctionOfTwo),
    Loop(Loop),
}

impl Operation {
    /// By how much the stack grows, or shrinks.
    fn growth(self) -> isize {
        match self {
            Self::Number(_) | Self::Variable(_) | Self::Parameter(_) => 1,
            Self::Negate | Self::Table | Self::Of(_) => 0,
            Self::Add
            | Self::Subtract
            | Self::Multiply
            | Self::Divide
            | Self::Power
            | Self::Surface
            | Self::OfTwo(_)
            | Self::Loop(_) => -1,
        }
    }
}

/// An expression, ready to be evaluated.
#[derive(Debug, Clone)]
pub struct Expression {
    /// In postfix order.
    operations: Vec<Operation>,
    /// Places of the table; none where there is none.
    places: Places,
    /// Parameters before the values of the table.
    named: usize,
    /// Variables, behind which comes what is remembered.
    variables: usize,
    remembered: Option<Remembered>,
}

/// What an expression remembers: how, the way of which variable, and where in its operations the
/// width is worked out.
#[derive(Debug, Clone)]
struct Remembered {
    law: Loop,
    variable: usize,
    width: Range<usize>,
}

/// Name of the function that reads the table.
const TABLE_FUNCTION: &str = "table";

/// What is wrong with the text of an expression, and where.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ExpressionMistake {
    /// Byte range in the expression.
    pub at: Range<usize>,
    /// What was read and what was expected.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

impl Expression {
    /// Reads an expression over these variables and parameters.
    ///
    /// # Errors
    /// [`ExpressionMistake`]: what is no expression, a name that is none of these, more than 32
    /// levels of parentheses or operands waiting for their operator, or more than 1000 operations.
    pub fn parse(
        text: &str,
        variables: &[&str],
        parameters: &[&str],
    ) -> Result<Self, ExpressionMistake> {
        Self::parse_with_table(text, variables, parameters, None)
    }

    /// The same with a table of values at these places: its values are parameters, in order, after
    /// those that have names.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn parse_with_table(
        text: &str,
        variables: &[&str],
        parameters: &[&str],
        table: Option<&Places>,
    ) -> Result<Self, ExpressionMistake> {
        let mut parser = Parser {
            text,
            at: 0,
            variables,
            parameters,
            table,
            operations: Vec::new(),
            held: 0,
            nesting: 0,
            remembered: None,
        };
        parser.sum()?;
        match parser.peek() {
            None => Ok(Self {
                operations: parser.operations,
                places: table.cloned().unwrap_or_default(),
                named: parameters.len(),
                variables: variables.len(),
                remembered: parser.remembered,
            }),
            Some(_) => Err(parser.unexpected("an operator (+ - * / ^) or the end")),
        }
    }

    /// Its value. Both slices in the order in which [`parse`](Self::parse) got the names; behind the
    /// variables the state of its [`Loop`], where it has one: 0 where none is given.
    #[inline]
    pub fn eval(&self, variables: &[f64], parameters: &[f64]) -> f64 {
        self.worked_out(&self.operations, variables, parameters)
    }

    /// Its [`Loop`] and the width of it; `None` where it has none.
    #[inline]
    pub fn remembered(&self, parameters: &[f64]) -> Option<(Loop, f64)> {
        let remembered = self.remembered.as_ref()?;
        let width = &self.operations[remembered.width.clone()];
        Some((remembered.law, self.worked_out(width, &[], parameters)))
    }

    /// Index of the variable whose way its [`Loop`] remembers.
    pub fn variable_remembered(&self) -> Option<usize> {
        self.remembered.as_ref().map(|r| r.variable)
    }

    #[inline]
    fn worked_out(&self, operations: &[Operation], variables: &[f64], parameters: &[f64]) -> f64 {
        let mut stack = [0.0; EXPRESSION_DEPTH_MAX];
        let mut held = 0;
        for operation in operations {
            let value = match *operation {
                Operation::Number(number) => number,
                Operation::Variable(i) => variables[i],
                Operation::Parameter(i) => parameters[i],
                Operation::Negate | Operation::Table | Operation::Of(_) => {
                    held -= 1;
                    let a = stack[held];
                    match *operation {
                        Operation::Of(function) => function(a),
                        Operation::Table => self.places.value(&parameters[self.named..], [a, 0.0]),
                        _ => -a,
                    }
                }
                binary => {
                    held -= 2;
                    let (a, b): (f64, f64) = (stack[held], stack[held + 1]);
                    match binary {
                        Operation::Add => a + b,
                        Operation::Subtract => a - b,
                        Operation::Multiply => a * b,
                        Operation::Divide => a / b,
                        Operation::OfTwo(function) => function(a, b),
                        Operation::Surface => self.places.value(&parameters[self.named..], [a, b]),
                        Operation::Loop(law) => {
                            law.value(a, b, variables.get(self.variables).copied().unwrap_or(0.0))
                        }
                        _ => a.powf(b),
                    }
                }
            };
            stack[held] = value;
            held += 1;
        }
        stack[0]
    }

    /// True where the variable at this index occurs.
    pub fn has_variable(&self, index: usize) -> bool {
        self.operations.iter().any(|o| matches!(o, Operation::Variable(i) if *i == index))
    }

    /// True where the parameter at this index occurs.
    pub fn has_parameter(&self, index: usize) -> bool {
        let of_table = index >= self.named;
        self.operations.iter().any(|o| match o {
            Operation::Parameter(i) => *i == index,
            Operation::Table | Operation::Surface => of_table,
            _ => false,
        })
    }
}

/// True where a text can be a parameter's name: a letter, then letters, digits and underscores, and
/// not taken.
pub(super) fn may_be_named(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|c| c.is_ascii_alphabetic())
        && letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !known_words().any(|word| word == name)
}

fn known_words<'k>() -> impl Iterator<Item = &'k str> {
    let functions = FUNCTIONS.iter().map(|(n, _)| *n);
    let of_two = FUNCTIONS_OF_TWO.iter().map(|(n, _)| *n);
    functions.chain(of_two).chain(LOOP_NAMES.iter().map(|(n, _)| *n)).chain(["pi"])
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
    variables: &'t [&'t str],
    parameters: &'t [&'t str],
    table: Option<&'t Places>,
    operations: Vec<Operation>,
    /// Values on the stack after the operations so far.
    held: usize,
    nesting: usize,
    remembered: Option<Remembered>,
}

impl Parser<'_> {
    /// The next character that is no blank.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn eat(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += if found { wanted.len_utf8() } else { 0 };
        found
    }

    /// The bytes from here on that all are so.
    fn run(&mut self, belongs: impl Fn(u8) -> bool) -> Range<usize> {
        let start = self.at;
        self.at += self.text[start..].bytes().take_while(|b| belongs(*b)).count();
        start..self.at
    }

    fn mistake(&self, at: Range<usize>, message: String, help: &str) -> ExpressionMistake {
        ExpressionMistake { at, message, help: help.to_owned() }
    }

    fn unexpected(&mut self, expected: &str) -> ExpressionMistake {
        let (read, at) = match self.peek() {
            Some(c) => (format!("`{}`", c.escape_debug()), self.at..self.at + c.len_utf8()),
            None => ("the end of the expression".to_owned(), self.text.len()..self.text.len()),
        };
        let help = "An expression is written as c * tanh(link_rate / 0.01) + s * link; every product with its `*`.";
        self.mistake(at, format!("read {read}; expected {expected}"), help)
    }

    fn emit(&mut self, operation: Operation) -> Result<(), ExpressionMistake> {
        if self.operations.len() == MOST_OPERATIONS {
            let message = format!(
                "more than {MOST_OPERATIONS} numbers, names and operators; expected at most so many"
            );
            let help = "It would be evaluated at every step of the plant: shorten it.";
            return Err(self.mistake(self.at..self.at, message, help));
        }
        self.operations.push(operation);
        self.held = self.held.saturating_add_signed(operation.growth());
        if self.held > EXPRESSION_DEPTH_MAX { Err(self.too_deep()) } else { Ok(()) }
    }

    fn too_deep(&self) -> ExpressionMistake {
        let message = format!(
            "more than {EXPRESSION_DEPTH_MAX} levels deep here; expected at most {EXPRESSION_DEPTH_MAX}"
        );
        self.mistake(
            self.at..self.at,
            message,
            "Split the expression into two effects at the same port: they add up.",
        )
    }

    fn deeper(
        &mut self,
        inner: impl FnOnce(&mut Self) -> Result<(), ExpressionMistake>,
    ) -> Result<(), ExpressionMistake> {
        self.nesting += 1;
        if self.nesting > EXPRESSION_DEPTH_MAX {
            return Err(self.too_deep());
        }
        inner(self)?;
        self.nesting -= 1;
        Ok(())
    }

    fn sum(&mut self) -> Result<(), ExpressionMistake> {
        self.product()?;
        loop {
            let operation = match self.peek() {
                Some('+') => Operation::Add,
                Some('-') => Operation::Subtract,
                _ => return Ok(()),
            };
            self.at += 1;
            self.product()?;
            self.emit(operation)?;
        }
    }

    fn product(&mut self) -> Result<(), ExpressionMistake> {
        self.signed()?;
        loop {
            let operation = match self.peek() {
                Some('*') => Operation::Multiply,
                Some('/') => Operation::Divide,
                _ => return Ok(()),
            };
            self.at += 1;
            self.signed()?;
            self.emit(operation)?;
        }
    }

    fn signed(&mut self) -> Result<(), ExpressionMistake> {
        let mut negative = false;
        loop {
            if self.eat('-') {
                negative = !negative;
            } else if !self.eat('+') {
                break;
            }
        }
        self.value()?;
        if self.eat('^') {
            self.deeper(Self::signed)?;
            self.emit(Operation::Power)?;
        }
        if negative { self.emit(Operation::Negate) } else { Ok(()) }
    }

    fn value(&mut self) -> Result<(), ExpressionMistake> {
        match self.peek() {
            Some('(') => self.parenthesised(1).map(|_| ()),
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            _ => Err(self.unexpected("a number, a name or `(`")),
        }
    }

    /// `(`, so many sums between commas, `)`; where the operations of the last sum begin.
    fn parenthesised(&mut self, sums: usize) -> Result<usize, ExpressionMistake> {
        let (open, mut last) = (self.at, self.operations.len());
        if !self.eat('(') {
            return Err(self.unexpected("`(`"));
        }
        self.deeper(|inner| {
            for i in 0..sums {
                if i > 0 && !inner.eat(',') {
                    return Err(inner.unexpected("`,` and a second value"));
                }
                last = inner.operations.len();
                inner.sum()?;
            }
            Ok(())
        })?;
        if self.eat(')') {
            return Ok(last);
        }
        let mut mistake = self.unexpected("an operator or `)`");
        if self.peek().is_none() {
            mistake.at = open..open + 1;
            mistake.message = "`(` is never closed; expected its `)`".to_owned();
        }
        Err(mistake)
    }

    fn number(&mut self) -> Result<(), ExpressionMistake> {
        let start = self.at;
        self.run(|b| b.is_ascii_digit() || b == b'.');
        if self.text[self.at..].starts_with(['e', 'E']) {
            let mantissa = self.at;
            self.at += 1;
            if self.text[self.at..].starts_with(['+', '-']) {
                self.at += 1;
            }
            if self.run(|b| b.is_ascii_digit()).is_empty() {
                self.at = mantissa;
            }
        }
        let read = &self.text[start..self.at];
        match read.parse() {
            Ok(number) if f64::is_finite(number) => self.emit(Operation::Number(number)),
            _ => {
                let message = format!("read `{read}`; expected a finite number");
                Err(self.mistake(start..self.at, message, "Write a number as 12, 0.5 or 3e-4."))
            }
        }
    }

    fn name(&mut self) -> Result<(), ExpressionMistake> {
        let span = self.run(|b| b.is_ascii_alphanumeric() || b == b'_');
        let name = &self.text[span.clone()];
        let index = |names: &[&str]| names.iter().position(|n| *n == name);
        if let Some((_, function)) = FUNCTIONS.iter().find(|(n, _)| *n == name) {
            self.parenthesised(1)?;
            self.emit(Operation::Of(*function))
        } else if let Some((_, function)) = FUNCTIONS_OF_TWO.iter().find(|(n, _)| *n == name) {
            self.parenthesised(2)?;
            self.emit(Operation::OfTwo(*function))
        } else if let Some((_, law)) = LOOP_NAMES.iter().find(|(n, _)| *n == name) {
            self.remembering(*law, span)
        } else if let Some(places) = self.table.filter(|_| name == TABLE_FUNCTION) {
            let over_two = !places.across.is_empty();
            self.parenthesised(1 + usize::from(over_two))?;
            self.emit(if over_two { Operation::Surface } else { Operation::Table })
        } else if name == "pi" {
            self.emit(Operation::Number(std::f64::consts::PI))
        } else if let Some(i) = index(self.variables) {
            self.emit(Operation::Variable(i))
        } else if let Some(i) = index(self.parameters) {
            self.emit(Operation::Parameter(i))
        } else {
            Err(self.unknown(name, span))
        }
    }

    /// The variable and the width of a loop whose name was read at `at`.
    fn remembering(&mut self, law: Loop, at: Range<usize>) -> Result<(), ExpressionMistake> {
        let from = self.operations.len();
        let last = self.parenthesised(2)?;
        let of = &self.text[at.start..self.at];
        let help = "A loop is written as height * dahl(link, width), one in an expression: two effects at the same port add up.";
        let wrong = |expected: &str| {
            let message = format!("read `{of}`; expected {expected}");
            Err(ExpressionMistake { at: at.start..self.at, message, help: help.to_owned() })
        };
        let &[Operation::Variable(variable)] = &self.operations[from..last] else {
            return wrong("a variable, whose way is remembered, and then the width of the loop");
        };
        let width = last..self.operations.len();
        let varies = |o: &Operation| matches!(o, Operation::Variable(_) | Operation::Loop(_));
        if self.operations[width.clone()].iter().any(varies) {
            return wrong("a width made of numbers and parameters alone");
        }
        if self.remembered.is_some() {
            return wrong("one such loop in an expression");
        }
        self.remembered = Some(Remembered { law, variable, width });
        self.emit(Operation::Loop(law))
    }

    fn unknown(&self, name: &str, at: Range<usize>) -> ExpressionMistake {
        let table = self.table.map(|_| TABLE_FUNCTION);
        let names = self.variables.iter().chain(self.parameters).copied();
        let names = names.chain(known_words()).chain(table);
        let guess =
            nearest(name, names).map(|n| format!(" Did you mean `{n}`?")).unwrap_or_default();
        let list = |names: &[&str]| {
            if names.is_empty() { "none".to_owned() } else { names.join(", ") }
        };
        let message = format!(
            "`{name}` is no variable of this port, no parameter and no function; expected one of the variables {}, the \
             parameters ({})",
            list(self.variables),
            list(self.parameters)
        );
        let functions = known_words().collect::<Vec<_>>().join(", ");
        self.mistake(at, message, &format!("Functions and constants are {functions}.{guess}"))
    }
}
