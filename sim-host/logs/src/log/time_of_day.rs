//! Times that are written as a time of day, `10:57:00.004`, or as ISO 8601, `2024-05-17T10:57:00.004Z`.

/// Seconds of a time of day from midnight, of a date from the beginning of 1970; a zone is left out,
/// as it is the same in all rows.
pub(super) fn seconds(text: &str) -> Option<f64> {
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
    let of_day = 3600.0 * hours + 60.0 * minutes + seconds;
    match date {
        Some(date) => Some(86_400.0 * days(date)? as f64 + of_day),
        None => Some(of_day),
    }
}

/// Days of a date `2024-05-17` from the beginning of 1970.
fn days(date: &str) -> Option<i64> {
    let numbers: Vec<i64> =
        date.split(['-', '/']).map(|part| part.parse().ok()).collect::<Option<_>>()?;
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
    use super::seconds;

    #[test]
    fn times_of_day_and_dates_are_seconds() {
        assert_eq!(seconds("10:57:00.004"), Some(39_420.004));
        assert_eq!(seconds("1970-01-01T00:00:00Z"), Some(0.0));
        // A leap day, and the same instant with a zone and a comma.
        let day = 86_400.0 * 19_782.0;
        assert_eq!(seconds("2024-02-29 12:00:00.5"), Some(day + 43_200.5));
        assert_eq!(seconds("2024-02-29T12:00:00,5+02:00"), Some(day + 43_200.5));
        for text in ["10:57", "24:00:00", "-1:00:00", "10:57:00:00", "17.05.2024", "12", "a:b:c"] {
            assert_eq!(seconds(text), None, "{text}");
        }
    }
}
