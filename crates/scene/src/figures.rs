//! Numbers as plans print them.

/// A length in metres or kilometres.
pub(crate) fn length(length_m: f64) -> String {
    if length_m >= 1000.0 {
        format!("{} km", brief(length_m / 1000.0))
    } else {
        format!("{} m", brief(length_m))
    }
}

/// About two significant digits.
pub(crate) fn brief(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        // A stored zero: nothing was computed.
        "0".to_string()
    } else if size >= 100.0 {
        format!("{value:.0}")
    } else if size >= 10.0 {
        format!("{value:.1}").trim_end_matches(".0").to_string()
    } else if size >= 0.01 {
        let text = format!("{value:.2}");
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{value:.1e}")
    }
}
