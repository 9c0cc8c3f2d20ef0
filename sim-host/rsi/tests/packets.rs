//! Both packets as public clients and drivers write and read them, and garbage.

use proptest::prelude::*;
use trueweld_rsi::packet::{Element, PacketError, Rob, SeamReading, Sen, WeldChannels};

fn rob() -> Rob {
    Rob {
        actual: [5.32, 6.4, 111.3, 12.2, 0.0, 12.5],
        commanded: None,
        axes: [8.2, 3.3, 111.67, 12.2222, -35.2, -12.5],
        commanded_axes: None,
        external: [1000.0, 2000.0, 3000.0, 4000.0, 5000.0, 6000.0],
        delay: 11,
        weld: None,
        ipoc: 357,
    }
}

fn weld_channels() -> WeldChannels {
    WeldChannels {
        torque: [1e3, -2e4, 3.0, 4.0, 5.0, 6.5],
        wrench: [-4e3, 1e3, -18e3, 1.0, 2.0, 3.0],
        path: 123.456,
        feed: 10.0,
        push: 18e3,
        seam: vec![
            SeamReading { across: true, value: 0.0512, age: 20.0 },
            SeamReading { across: false, value: -0.01, age: 20.0 },
        ],
    }
}

/// What the controller's packet is, to the byte: kroshu/kuka-external-control-sdk reads values at
/// fixed distances from each other, and its tests hold packets of this form.
#[test]
fn the_controllers_packet_is_that_of_public_clients_to_the_byte() {
    assert_eq!(
        String::from_utf8(rob().to_bytes(&Element::PLAIN)).unwrap(),
        "<Rob Type=\"KUKA\"><RIst X=\"5.32000\" Y=\"6.40000\" Z=\"111.30000\" A=\"12.20000\" \
         B=\"0.00000\" C=\"12.50000\"/><AIPos A1=\"8.20000\" A2=\"3.30000\" A3=\"111.67000\" \
         A4=\"12.22220\" A5=\"-35.20000\" A6=\"-12.50000\"/><EIPos E1=\"1000.00000\" \
         E2=\"2000.00000\" E3=\"3000.00000\" E4=\"4000.00000\" E5=\"5000.00000\" \
         E6=\"6000.00000\"/><Delay D=\"11\"/><IPOC>357</IPOC></Rob>"
    );
}

/// Reads numbers between literals that must stand exactly there: a blank more, and a client that
/// reads by position is lost.
fn by_position(text: &str) -> Option<Vec<f64>> {
    let mut literals = vec!["<Rob Type=\"KUKA\"><RIst X=\"".to_owned()];
    literals.extend(["Y", "Z", "A", "B", "C"].map(|n| format!("\" {n}=\"")));
    literals.push("\"/><AIPos A1=\"".to_owned());
    literals.extend((2..7).map(|n| format!("\" A{n}=\"")));
    literals.push("\"/><EIPos E1=\"".to_owned());
    literals.extend((2..7).map(|n| format!("\" E{n}=\"")));
    literals.extend(["\"/><Delay D=\"", "\"/><IPOC>"].map(str::to_owned));
    let mut rest = text;
    let mut numbers = Vec::new();
    for literal in literals {
        rest = rest.strip_prefix(&literal)?;
        let end = rest.find(['"', '<'])?;
        numbers.push(rest[..end].parse().ok()?);
        rest = &rest[end..];
    }
    (rest == "</IPOC></Rob>").then_some(numbers)
}

#[test]
fn a_client_of_commands_is_understood() {
    // As kroshu/kuka-external-control-sdk sends.
    let sen = "<Sen Type=\"KROSHU\"><Stop>1</Stop><AK A1=\"194.805650\" A2=\"-1.000000\" \
               A3=\"0.000000\" A4=\"0.000000\" A5=\"0.000000\" A6=\"2.500000\"/>\
               <IPOC>543265442</IPOC></Sen>";
    let expected = Sen {
        correction: [0.0; 6],
        axes: [194.80565, -1.0, 0.0, 0.0, 0.0, 2.5],
        stop: true,
        ipoc: 543265442,
    };
    assert_eq!(Sen::read(sen.as_bytes()), Ok(expected));
    // As KUKA's own example answers, with elements that nobody asked for, over several lines.
    let sen = "<Sen Type=\"ImFree\">\r\n<EStr>Message from RSI TestServer</EStr>\r\n\
               <Tech T21=\"1.09\" T22=\"2.08\" />\r\n<RKorr X=\"4.5\" Y=\"-1\" Z=\"0.0000\" A=\"0\" \
               B=\"0.25\" C=\"0.0000\" />\r\n<DiO>125</DiO>\r\n<IPOC>123645634563</IPOC>\r\n</Sen>\0";
    let read = Sen::read(sen.as_bytes()).unwrap();
    assert_eq!(read.correction, [4.5, -1.0, 0.0, 0.0, 0.25, 0.0]);
    assert!(!read.stop && read.ipoc == 123645634563);
}

/// As the ROS-Industrial driver's ETHERNET file asks for them: it reads through a null pointer where
/// one of them is missing.
#[test]
fn a_packet_has_the_elements_that_a_client_asks_for_in_their_order() {
    let frame = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0];
    let packet = Rob {
        commanded: Some(frame),
        commanded_axes: Some([7.0; 6]),
        weld: Some(weld_channels()),
        ..rob()
    };
    use Element::{AIPos, ASPos, Delay, RIst, RSol};
    let bytes = packet.to_bytes(&[RIst, RSol, AIPos, ASPos, Delay]);
    let text = String::from_utf8(bytes.clone()).unwrap();
    let tags: Vec<&str> = text.split('<').filter_map(|part| part.split(' ').next()).collect();
    let expected =
        ["", "Rob", "RIst", "RSol", "AIPos", "ASPos", "Delay", "IPOC>357", "/IPOC>", "/Rob>"];
    assert_eq!(tags, expected);
    let back = Rob::read(&bytes).unwrap();
    assert_eq!((back.commanded, back.commanded_axes), (Some(frame), Some([7.0; 6])));
    assert_eq!((back.actual, back.axes, back.weld), (packet.actual, packet.axes, None));
}

#[test]
fn components_that_a_context_lacks_are_not_corrected() {
    let read = |text: &str| Sen::read(format!("<Sen>{text}<IPOC>7</IPOC></Sen>").as_bytes());
    let sen = read("<RKorr X=\"0.1\" Y=\"   -0.2\" Z=\"0.3\"/>").unwrap();
    assert_eq!(sen.correction, [0.1, -0.2, 0.3, 0.0, 0.0, 0.0]);
    assert_eq!(read("<AK A6=\"1.5\"/>").unwrap().axes, [0.0, 0.0, 0.0, 0.0, 0.0, 1.5]);
}

#[test]
fn what_is_wrong_with_a_packet_is_told_with_its_place() {
    let good = String::from_utf8(Sen { ipoc: 7, ..Sen::default() }.to_bytes()).unwrap();
    let told = |bytes: &[u8]| Sen::read(bytes).expect_err("it is wrong").to_string();
    let read = |from: &str, to: &str| told(good.replacen(from, to, 1).as_bytes());
    let x = "X=\"0.00000\"";
    for wrong in ["nan", "1e999", "", "0,1"] {
        let expected = format!("RKorr X is {wrong:?}, no number that it can be");
        assert_eq!(read(x, &format!("X=\"{wrong}\"")), expected);
    }
    assert_eq!(read(x, "x=\"0.1\""), "RKorr x is not known");
    assert_eq!(read("<IPOC>7</IPOC>", ""), "IPOC is missing");
    assert_eq!(read("<IPOC>7<", "<IPOC>-7<"), "IPOC is \"-7\", no number that it can be");
    assert_eq!(read("<IPOC>", "<IPOC>6</IPOC><IPOC>"), "IPOC stands twice");
    assert_eq!(read("<Stop>0", "<Stop>2"), "Stop is \"2\", no number that it can be");
    assert_eq!(Rob::read(good.as_bytes()), Err(PacketError::Root("Rob")));
    let rob = String::from_utf8(rob().to_bytes(&Element::PLAIN)).unwrap();
    let lacks = Rob::read(rob.replace(" A4=\"12.22220\"", "").as_bytes());
    assert_eq!(lacks, Err(PacketError::Missing("AIPos A4".to_owned())));
    let latin = good.replacen("<EStr>", "<EStr>\u{d6}", 1).into_bytes();
    let latin: Vec<u8> = latin.into_iter().filter(|byte| *byte != 0xc3).collect();
    assert!(told(&latin).starts_with("it is no XML: invalid utf-8 sequence"), "{}", told(&latin));
    let xml = |bytes: &[u8]| matches!(Sen::read(bytes), Err(PacketError::Xml(_)));
    assert!(xml(good.replacen("Sen", "Rob", 1).as_bytes()));
    assert!(xml(b"<!DOCTYPE Sen [<!ENTITY a \"1\">]><Sen><IPOC>&a;</IPOC></Sen>"));
    assert!(xml(&[b'<'; 5000]));
    assert!(xml("<Sen>".repeat(800).as_bytes()));
}

proptest! {
    #[test]
    fn a_packet_comes_back_and_is_read_by_position(
        actual in prop::array::uniform6(-4000.0..4000.0),
        axes in prop::array::uniform6(-350.0..350.0),
        delay in 0_u32..1000,
        ipoc in any::<u64>(),
        weld in any::<bool>(),
    ) {
        let packet = Rob { actual, axes, delay, ipoc, weld: None, ..rob() };
        let text = String::from_utf8(packet.to_bytes(&Element::PLAIN)).unwrap();
        let numbers = by_position(&text).expect("every value at its place");
        for (read, written) in numbers.iter().zip(actual.iter().chain(&axes)) {
            // Five digits behind the point.
            prop_assert!((read - written).abs() <= 0.5e-5 + 1e-12);
        }
        let packet = Rob {
            commanded: Some([1.0, -2.0, 3.0, -4.0, 5.0, -6.0]),
            weld: weld.then(weld_channels),
            ..packet
        };
        let bytes = packet.to_bytes(&Element::WELD);
        // A client's buffer, of the one that reads by position.
        prop_assert!(bytes.len() < 1024);
        let back = Rob::read(&bytes).unwrap();
        prop_assert_eq!(back.ipoc, ipoc);
        prop_assert_eq!(back.delay, delay);
        prop_assert_eq!(&back.weld, &packet.weld);
        for (read, written) in back.axes.iter().zip(&axes) {
            prop_assert!((read - written).abs() <= 0.5e-5 + 1e-12);
        }
    }

    #[test]
    fn any_bytes_are_read_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let _ = Sen::read(&bytes);
        let _ = Rob::read(&bytes);
    }

    #[test]
    fn a_damaged_packet_is_read_without_a_panic_and_holds_finite_numbers_alone(
        at in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        weld in any::<bool>(),
    ) {
        let sen = Sen { correction: [1.0, -2.0, 0.5, 0.1, 0.2, 0.3], ipoc: 99, ..Sen::default() };
        let rob = Rob { weld: weld.then(weld_channels), ..rob() };
        for bytes in [sen.to_bytes(), rob.to_bytes(&Element::WELD)] {
            let mut bytes = bytes;
            for (index, byte) in &at {
                let place = index.index(bytes.len());
                bytes[place] = *byte;
            }
            for bytes in [&bytes[..], &bytes[..cut.index(bytes.len())]] {
                if let Ok(read) = Sen::read(bytes) {
                    prop_assert!(read.correction.iter().chain(&read.axes).all(|v| v.is_finite()));
                }
                if let Ok(read) = Rob::read(bytes) {
                    prop_assert!(read.actual.iter().chain(&read.axes).all(|v| v.is_finite()));
                }
            }
        }
    }
}
