//! The importer's pointers: what believes them.

use std::borrow::Cow;
use std::ffi::{CStr, c_char};
use std::path::PathBuf;
use std::slice;

/// Values that lie one after another.
///
/// # Safety
/// `first` is null or has `count` values that nothing writes to while the slice lives.
pub(super) unsafe fn values<'a, V>(first: *const V, count: usize) -> Result<&'a [V], String> {
    match (first.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err("a pointer to values is null".to_owned()),
        // SAFETY: not null, and the values are there by the caller's promise.
        (false, _) => Ok(unsafe { slice::from_raw_parts(first, count) }),
    }
}

/// Room for values.
///
/// # Safety
/// `first` is null or has room for `count` values that nothing else uses while the slice lives.
pub(super) unsafe fn room<'a, V>(first: *mut V, count: usize) -> Result<&'a mut [V], String> {
    match (first.is_null(), count) {
        (_, 0) => Ok(&mut []),
        (true, _) => Err("a pointer to room for values is null".to_owned()),
        // SAFETY: not null, and the room is there by the caller's promise.
        (false, _) => Ok(unsafe { slice::from_raw_parts_mut(first, count) }),
    }
}

/// Writes one value; a null pointer asks for none.
///
/// # Safety
/// `to` is null or has room for a value.
pub(super) unsafe fn write<V>(to: *mut V, value: V) {
    if !to.is_null() {
        // SAFETY: not null, with room by the caller's promise.
        unsafe { to.write(value) };
    }
}

/// A text; empty for a null pointer.
///
/// # Safety
/// `text` is null or ends with 0, and nothing writes to it while the text lives.
pub(super) unsafe fn text<'a>(text: *const c_char) -> Cow<'a, str> {
    if text.is_null() {
        return Cow::Borrowed("");
    }
    // SAFETY: not null, and ended by the caller's promise.
    unsafe { CStr::from_ptr(text) }.to_string_lossy()
}

/// The folder of a `file` URI, as FMI 2.0 gives it; a text without a scheme is a path.
pub(super) fn folder_of(uri: &str) -> Result<PathBuf, String> {
    let Some(rest) = uri.strip_prefix("file:") else {
        return Ok(PathBuf::from(uri));
    };
    // An authority, which is empty or this machine, ends where the path begins.
    let path = match rest.strip_prefix("//") {
        Some(authority) => {
            let place = authority.find('/').ok_or_else(|| format!("{uri} names no folder"))?;
            &authority[place..]
        }
        None => rest,
    };
    // `/C:/folder`
    let is_drive = path.as_bytes().get(2) == Some(&b':') && path.starts_with('/');
    Ok(PathBuf::from(percent_decoded(if is_drive { &path[1..] } else { path })?))
}

fn percent_decoded(text: &str) -> Result<String, String> {
    let wrong = || format!("{text} is no URI");
    let mut bytes = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let mut digit = || rest.next().and_then(|digit| char::from(digit).to_digit(16));
        let (high, low) = (digit().ok_or_else(wrong)?, digit().ok_or_else(wrong)?);
        bytes.push((high * 16 + low) as u8);
    }
    String::from_utf8(bytes).map_err(|_| wrong())
}

#[cfg(test)]
mod tests {
    use super::folder_of;

    #[test]
    fn a_uri_names_a_folder() {
        for (uri, folder) in [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/resources", "/tmp/resources"),
            ("file://localhost/tmp/%C3%A4", "/tmp/ä"),
            ("file:///C:/fmu/resources", "C:/fmu/resources"),
            ("/tmp/resources", "/tmp/resources"),
        ] {
            assert_eq!(folder_of(uri).as_deref(), Ok(std::path::Path::new(folder)), "{uri}");
        }
        for uri in ["file:///tmp/%2", "file:///tmp/%zz", "file://host", "file:///%ff"] {
            assert!(folder_of(uri).is_err(), "{uri}");
        }
    }
}
