//! Times that are written as a time of day, `10:57:00.004` or `10:57:00.004 PM`, or as ISO 8601,
//! `2024-05-17T10:57:00.004Z`; dates also as `17.05.2024`.

/// Seconds of a day.
const DAY: f64 = 86_400.0;

/// Seconds of a time of day from midnight, of a date from the beginning of 1970; a zone is left out,
/// as it is the same in all rows.
pub(super) fn seconds(text: &str) -> Option<f64> {
    let (text, noon) = halved(text);
    let (date, time) = match text.split_once(['T', ' ']) {
        Some((date, time)) => (Some(date), time.trim_start()),
        None => (None, text),
    };
    let time = time.trim_end_matches('Z');
    let time = time.split(['+', '-']).next().unwrap_or(time);
    let mut parts = time.split(':');
    let mut part = |most: f64| {
        let part = parts.next()?;
        let digits = part.starts_with(|c: char| c.is_ascii_digit());
        // A comma may be the decimal mark of the seconds.
        let value = part.replace(',', ".").parse::<f64>().ok().filter(|_| digits)?;
        (0.0..most).contains(&value).then_some(value)
    };
    let (hours, minutes, seconds) = (part(24.0)?, part(60.0)?, part(61.0)?);
    if parts.next().is_some() || hours.fract() != 0.0 || minutes.fract() != 0.0 {
        return None;
    }
    let hours = match noon {
        Some(noon) if (1.0..=12.0).contains(&hours) => hours % 12.0 + noon,
        Some(_) => return None,
        None => hours,
    };
    let of_day = 3600.0 * hours + 60.0 * minutes + seconds;
    match date {
        Some(date) => Some(DAY * days(date)? as f64 + of_day),
        None => Some(of_day),
    }
}

/// A time without AM or PM, and the hours that it adds to those of a half day.
fn halved(text: &str) -> (&str, Option<f64>) {
    let Some(at) = text.len().checked_sub(2).filter(|at| text.is_char_boundary(*at)) else {
        return (text, None);
    };
    let (time, half) = text.split_at(at);
    match half.to_ascii_uppercase().as_str() {
        "AM" => (time.trim_end(), Some(0.0)),
        "PM" => (time.trim_end(), Some(12.0)),
        _ => (text, None),
    }
}

/// Times of day that go on over midnight.
#[derive(Debug, Default)]
pub(super) struct Midnights {
    last: Option<f64>,
    days: f64,
}

impl Midnights {
    /// The time with the days that passed since the first. A time of day that is half a day earlier than
    /// the one before is of the next day.
    pub(super) fn continued(&mut self, seconds: f64) -> f64 {
        let of_day = (0.0..DAY).contains(&seconds);
        if of_day && self.last.is_some_and(|last| seconds < last - 0.5 * DAY) {
            self.days += 1.0;
        }
        self.last = Some(seconds).filter(|_| of_day);
        if of_day { seconds + DAY * self.days } else { seconds }
    }
}

/// Days of a date `2024-05-17` or `17.05.2024` from the beginning of 1970.
fn days(date: &str) -> Option<i64> {
    let mut numbers: Vec<i64> =
        date.split(['-', '/', '.']).map(|part| part.parse().ok()).collect::<Option<_>>()?;
    if date.contains('.') {
        numbers.reverse();
    }
    let &[year, month, day] = numbers.as_slice() else { return None };
    if !(1000..=9999).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Years that begin in March end with the leap day; 306 days are before the first of them.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let leaps = year / 4 - year / 100 + year / 400;
    let since_march = (153 * month + 2) / 5 + day - 1;
    Some(365 * year + leaps + since_march - 719_468)
}

#[cfg(test)]
mod tests {
    use super::{Midnights, seconds};

    #[test]
    fn times_of_day_and_dates_are_seconds() {
        assert_eq!(seconds("10:57:00.004"), Some(39_420.004));
        assert_eq!(seconds("1970-01-01T00:00:00Z"), Some(0.0));
        // A leap day, and the same instant with a zone and a comma.
        let day = 86_400.0 * 19_782.0;
        assert_eq!(seconds("2024-02-29 12:00:00.5"), Some(day + 43_200.5));
        assert_eq!(seconds("2024-02-29T12:00:00,5+02:00"), Some(day + 43_200.5));
        assert_eq!(seconds("29.02.2024 12:00:00,5"), Some(day + 43_200.5));
        assert_eq!(seconds("12:00:01 AM"), Some(1.0));
        assert_eq!(seconds("2024-02-29 12:00:00.5 pm"), Some(day + 43_200.5));
        for text in [
            "13:00:00 PM",
            "ö",
            "10:57",
            "24:00:00",
            "-1:00:00",
            "10:57:00:00",
            "17.05.2024",
            "12",
            "a:b:c",
        ] {
            assert_eq!(seconds(text), None, "{text}");
        }
    }

    #[test]
    fn midnight_is_passed() {
        let mut midnights = Midnights::default();
        let read = [86_399.9, 0.1, 0.2, 86_399.0, 3.0].map(|t| midnights.continued(t));
        assert_eq!(read, [86_399.9, 86_400.1, 86_400.2, 172_799.0, 172_803.0]);
    }
}
