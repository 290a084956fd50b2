//! Nearest names.

/// `; did you mean `x`?`, or nothing if no name is near.
pub(crate) fn did_you_mean<'a>(wrong: &str, known: impl Iterator<Item = &'a str>) -> String {
    nearest(wrong, known).map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}

/// The nearest name, if one is near, and all of them: `; did you mean `x`? It takes x and y`.
pub(crate) fn offer(wrong: &str, verb: &str, known: &[&str]) -> String {
    match nearest(wrong, known.iter().copied()) {
        Some(name) => format!("; did you mean `{name}`? It {verb} {}", listed(known)),
        None => format!("; it {verb} {}", listed(known)),
    }
}

/// The name that was probably meant: few letters away, or a longer or shorter form of the same.
pub(crate) fn nearest<'a>(wrong: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let low = wrong.to_lowercase();
    known
        .map(|name| {
            let distance = strsim::damerau_levenshtein(&low, &name.to_lowercase());
            let contained =
                low.len() >= 3 && name.len() >= 3 && (name.contains(&*low) || low.contains(name));
            (name, if contained { distance.min(1) } else { distance })
        })
        .filter(|(name, distance)| *distance <= 1 + name.len().min(low.len()) / 4)
        .min_by_key(|(_, distance)| *distance)
        .map(|(name, _)| name)
}

/// `a, b and c`.
pub(crate) fn listed(names: &[&str]) -> String {
    match names {
        [] => "nothing".into(),
        [one] => (*one).into(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
