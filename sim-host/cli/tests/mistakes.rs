//! A mistake in the files is told in place of physics, and the line that is told undoes it.

use crate::support::{Workspace, fixture};
use serde_json::Value;
use std::fs;

/// The static log of a campaign of the model itself, with the rows changed.
fn campaign(place: &Workspace, change: impl Fn(&str, f64) -> f64) {
    let cell = place.path().join("cell");
    fs::create_dir_all(cell.join("static")).unwrap();
    let from = fixture("campaigns/nothing-missing");
    for file in ["robot.toml", "process.toml", "model.toml", "static/log.toml"] {
        fs::copy(format!("{from}/{file}"), cell.join(file)).unwrap();
    }
    let list = "schema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = [\"static\"]\n";
    fs::write(cell.join("campaign.toml"), list).unwrap();
    let rows = fs::read_to_string(format!("{from}/static/samples.csv")).unwrap();
    let mut lines = rows.lines();
    let header = lines.next().unwrap();
    let names: Vec<&str> = header.split(',').collect();
    let mut text = format!("{header}\n");
    for line in lines {
        let fields = line.split(',').zip(&names).map(|(field, name)| {
            field.parse().map_or(String::new(), |value| change(name, value).to_string())
        });
        text += &(fields.collect::<Vec<_>>().join(",") + "\n");
    }
    fs::write(cell.join("static/samples.csv"), text).unwrap();
}

fn json(place: &Workspace, name: &str) -> Value {
    serde_json::from_slice(&place.bytes(name)).unwrap()
}

#[test]
fn a_reversed_axis_is_named_with_the_line_that_undoes_it() {
    let place = Workspace::new();
    // Beyond the limits of A2, and so refused but for the mistake that explains it.
    campaign(&place, |name, value| if name == "qe2_rad" { -value } else { value });
    for command in ["compare", "diagnose"] {
        let text = place.done(&[command, "-q", "cell", "--json", "result.json"]);
        assert!(text.contains("the angle of A2 counts the other way"), "{text}");
        let result = json(&place, "result.json");
        let mistakes = result["mistakes"].as_array().unwrap();
        assert_eq!(mistakes.len(), 1, "{result}");
        assert_eq!((&mistakes[0]["what"], &mistakes[0]["at"]), (&"sign".into(), &"A2".into()));
        assert!(result["candidates"].as_array().is_none_or(Vec::is_empty), "{result}");
    }
    let result = json(&place, "result.json");
    let log = place.path().join("cell/static/log.toml");
    let line = result["mistakes"][0]["change"].as_str().unwrap();
    let text = fs::read_to_string(&log).unwrap();
    fs::write(&log, format!("{text}\n[columns]\n{line}\n")).unwrap();
    place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    let result = json(&place, "result.json");
    assert!(result["mistakes"].as_array().unwrap().is_empty(), "{result}");
    // 1.0 but for chance, as the campaign as it is.
    assert!(result["score"].as_f64().unwrap() < 1.2, "{}", result["score"]);
}

/// What controllers of FANUC and of arms with a parallelogram show of the third axis.
#[test]
fn an_axis_counted_from_the_horizontal_is_named_and_its_sum_undoes_it() {
    let place = Workspace::new();
    campaign(&place, |_, value| value);
    let samples = place.path().join("cell/static/samples.csv");
    let text = fs::read_to_string(&samples).unwrap();
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let [second, third] =
        ["qe2_rad", "qe3_rad"].map(|name| names.iter().position(|c| *c == name).unwrap());
    let shown = |line: &str| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let (Ok(a), Ok(b)) = (fields[second].parse::<f64>(), fields[third].parse::<f64>()) {
            fields[third] = (b - a).to_string();
        }
        fields.join(",") + "\n"
    };
    fs::write(&samples, text.lines().map(shown).collect::<String>()).unwrap();
    place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    let result = json(&place, "result.json");
    let mistake = &result["mistakes"][0];
    assert_eq!((&mistake["what"], &mistake["at"]), (&"coupling".into(), &"A3, A2".into()));
    let line = mistake["change"].as_str().unwrap();
    assert!(line.contains("plus = { qe2 = 1.0 }"), "{line}");
    let log = place.path().join("cell/static/log.toml");
    let text = fs::read_to_string(&log).unwrap();
    fs::write(&log, format!("{text}\n[columns]\n{line}\n")).unwrap();
    place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    let result = json(&place, "result.json");
    assert!(result["mistakes"].as_array().unwrap().is_empty(), "{result}");
    // 1.0 but for chance, as the campaign as it is.
    assert!(result["score"].as_f64().unwrap() < 1.2, "{}", result["score"]);
}

#[test]
fn a_moment_about_the_sensor_is_told_with_the_entry_that_takes_it_to_the_tool() {
    let place = Workspace::new();
    campaign(&place, |_, value| value);
    // A sensor 0.3 m behind the tool centre point: M + p × F, p = −0.3 m along z.
    let samples = place.path().join("cell/static/samples.csv");
    let text = fs::read_to_string(&samples).unwrap();
    let column = |name: &str| text.lines().next().unwrap().split(',').position(|c| c == name);
    let [fx, fy, mx, my] = ["fx_n", "fy_n", "mx_nm", "my_nm"].map(|name| column(name).unwrap());
    let of_sensor = |line: &str| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        let value = |fields: &[String], k: usize| fields[k].parse::<f64>();
        if let (Ok(x), Ok(y)) = (value(&fields, fx), value(&fields, fy)) {
            fields[mx] = (value(&fields, mx).unwrap() - 0.3 * y).to_string();
            fields[my] = (value(&fields, my).unwrap() + 0.3 * x).to_string();
        }
        fields.join(",") + "\n"
    };
    fs::write(&samples, text.lines().map(of_sensor).collect::<String>()).unwrap();
    let text = place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    assert!(text.contains("the moment is about a point 0."), "{text}");
    let result = json(&place, "result.json");
    let mistakes = result["mistakes"].as_array().unwrap();
    assert_eq!(mistakes.len(), 1, "{result}");
    assert_eq!(mistakes[0]["what"], "wrench-point");
    assert_eq!(mistakes[0]["change_in"], "log.toml, under [wrench]");
    let log = place.path().join("cell/static/log.toml");
    let text = fs::read_to_string(&log).unwrap();
    let table = |change: &str| fs::write(&log, format!("{text}\n[wrench]\n{change}\n")).unwrap();
    table(mistakes[0]["change"].as_str().unwrap());
    place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    let result = json(&place, "result.json");
    assert!(result["mistakes"].as_array().unwrap().is_empty(), "{result}");
    // 1.0 but for chance, as the campaign as it is.
    assert!(result["score"].as_f64().unwrap() < 1.2, "{}", result["score"]);

    // What the log says already is composed with what is found.
    table("point_m = [0.0, 0.1, 0.0]");
    place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    let result = json(&place, "result.json");
    let mistake = &result["mistakes"][0];
    assert_eq!(mistake["change_in"], "log.toml, in place of the table [wrench]");
    let (_, list) = mistake["change"].as_str().unwrap().split_once(" = ").unwrap();
    let point: Vec<f64> = serde_json::from_str(list).unwrap();
    for (read, set) in point.iter().zip([0.0, 0.0, -0.3]) {
        // Twice the centimetre that it is said to be known to.
        assert!((read - set).abs() < 0.02, "{point:?}");
    }
    table("point_m = [0.0, 0.0]");
    assert!(place.refused(&["compare", "cell"]).contains("a list of 3"));
}

/// What the proposed lines make of a log's `[columns]`: each takes the place of the one with its
/// header.
fn pasted(text: &str, change: &str) -> String {
    let header = |line: &str| line.split(" = ").next().map(str::to_owned);
    let lines: Vec<&str> = change.lines().filter(|line| !line.starts_with('#')).collect();
    let mut text = text.to_owned();
    for line in lines {
        let old = text.lines().find(|old| header(old) == header(line)).map(str::to_owned);
        match old {
            Some(old) => text = text.replace(&old, line),
            None => text = format!("{}\n{line}\n", text.trim_end()),
        }
    }
    text
}

/// Headers of a laboratory, mapped; one entry is wrong. The proposal is the whole line that takes its
/// place.
#[test]
fn the_line_that_undoes_a_mistake_is_composed_with_what_the_log_says() {
    let degrees = 180.0 / std::f64::consts::PI;
    for (wrong, right, what) in [
        ("unit = \"deg\", factor = -1.0", "unit = \"deg\" }", "sign"),
        ("unit = \"rad\"", "unit = \"deg\" }", "unit"),
        ("unit = \"deg\", offset = 40.0", "unit = \"deg\", offset = ", "zero"),
    ] {
        let place = Workspace::new();
        campaign(&place, |name, value| match name {
            "qe2_rad" | "qe5_rad" => value * degrees,
            name if name.starts_with('p') && name.ends_with("_m") => value * 1e3,
            _ => value,
        });
        let mapped = |text: &str| {
            let names = [("qe2_rad", "AXIS 2"), ("qe5_rad", "AXIS 5"), ("px_m", "X")];
            names.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
        };
        let samples = place.path().join("cell/static/samples.csv");
        fs::write(&samples, mapped(&fs::read_to_string(&samples).unwrap())).unwrap();
        let log = place.path().join("cell/static/log.toml");
        let text = fs::read_to_string(&log).unwrap();
        let text = format!(
            "{text}\n[columns]\n\"AXIS 2\" = {{ channel = \"qe2\", {wrong} }}\n\
             \"AXIS 5\" = {{ channel = \"qe5\", unit = \"deg\" }}\n\
             \"X\" = {{ channel = \"px\", unit = \"mm\" }}\n\
             \"py_m\" = {{ channel = \"py\", unit = \"mm\" }}\n\
             \"pz_m\" = {{ channel = \"pz\", unit = \"mm\" }}\n"
        );
        fs::write(&log, &text).unwrap();
        place.done(&["compare", "-q", "cell", "--json", "result.json"]);
        let result = json(&place, "result.json");
        let mistakes = result["mistakes"].as_array().unwrap();
        assert_eq!(mistakes.len(), 1, "{what}: {result}");
        assert_eq!((&mistakes[0]["what"], &mistakes[0]["at"]), (&what.into(), &"A2".into()));
        let change = mistakes[0]["change"].as_str().unwrap();
        assert!(
            change.contains(&format!("\"AXIS 2\" = {{ channel = \"qe2\", {right}")),
            "{change}"
        );
        assert!(mistakes[0]["change_in"].as_str().unwrap().contains("in place of"), "{result}");
        fs::write(&log, pasted(&text, change)).unwrap();
        place.done(&["compare", "-q", "cell", "--json", "result.json"]);
        let result = json(&place, "result.json");
        assert!(result["mistakes"].as_array().unwrap().is_empty(), "{what}: {result}");
        let score = result["score"].as_f64().unwrap();
        // A zero is told to what the poses tell of it, the rest of which is a calibration.
        assert!(score < if what == "zero" { 30.0 } else { 1.2 }, "{what}: {score}");
    }
}

/// A factor of a thousand that is in the log twice.
#[test]
fn a_unit_that_a_factor_says_once_more_is_taken_out() {
    let place = Workspace::new();
    campaign(&place, |name, value| {
        let position = name.starts_with('p') && name.ends_with("_m");
        if position { value * 1e3 } else { value }
    });
    let log = place.path().join("cell/static/log.toml");
    let mut text = fs::read_to_string(&log).unwrap() + "\n[columns]\n";
    for axis in ["px", "py", "pz"] {
        text +=
            &format!("\"{axis}_m\" = {{ channel = \"{axis}\", unit = \"mm\", factor = 0.001 }}\n");
    }
    fs::write(&log, &text).unwrap();
    place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    let change = json(&place, "result.json")["mistakes"][0]["change"].clone();
    let change = change.as_str().unwrap();
    assert!(change.contains("\"pz_m\" = { channel = \"pz\", unit = \"mm\" }"), "{change}");
    fs::write(&log, pasted(&text, change)).unwrap();
    place.done(&["compare", "-q", "cell", "--json", "result.json"]);
    let score = json(&place, "result.json")["score"].as_f64().unwrap();
    assert!(score < 1.2, "{score}");
}

#[test]
fn nothing_is_registered_on_top_of_a_mistake() {
    let place = Workspace::new();
    campaign(&place, |name, value| if name == "qe3_rad" { value + 0.5 } else { value });
    let refused = place.refused(&["register", "cell", "--write"]);
    assert!(refused.contains("the zero of A3 is off"), "{refused}");
    assert!(refused.contains("\"qe3_rad\" = { channel = \"qe3\""), "{refused}");
    let log = fs::read_to_string(place.path().join("cell/static/log.toml")).unwrap();
    assert!(!log.contains("[tracker]"), "{log}");
}

#[test]
fn a_tracker_that_stands_elsewhere_is_registered_and_written_down() {
    let place = Workspace::new();
    let metres_away = [("px_m", 3.0), ("py_m", -2.0), ("pz_m", 1.5)];
    campaign(&place, |name, value| {
        value + metres_away.iter().find(|(n, _)| *n == name).map_or(0.0, |(_, by)| *by)
    });
    let score = |place: &Workspace| {
        place.done(&["compare", "-q", "cell", "--json", "result.json"]);
        json(place, "result.json")["score"].as_f64().unwrap()
    };
    let registered = score(&place);
    assert!(registered < 1.3, "{registered}");
    place.done(&["register", "cell", "--write", "--json", "register.json"]);
    let base = json(&place, "register.json")["trackers"][0]["base"]["position_m"].clone();
    for (k, (_, by)) in metres_away.iter().enumerate() {
        // Noise of 30 µm in some dozens of poses, two metres from the base.
        assert!((base[k].as_f64().unwrap() - by).abs() < 3e-4, "{base}");
    }
    assert!((score(&place) - registered).abs() < 0.1);
    let again = place.refused(&["register", "cell", "--write"]);
    assert!(again.contains("[tracker]"), "{again}");
}
