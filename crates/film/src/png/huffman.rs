//! Huffman codes of limited length (RFC 1951, section 3.2).

/// The lengths of a prefix code for symbols of these frequencies: 0 for a symbol of frequency 0,
/// at most `limit` otherwise. The code is complete if there are two symbols or more; a single
/// symbol has length 1.
pub(crate) fn lengths(frequencies: &[u32], limit: u8, lengths: &mut [u8]) {
    lengths.fill(0);
    // By frequency, then by symbol, so that the code is the same everywhere.
    let mut symbols = [0_u64; 288];
    let mut count = 0;
    for (symbol, &frequency) in frequencies.iter().enumerate() {
        if frequency > 0 {
            symbols[count] = (u64::from(frequency) << 16) | symbol as u64;
            count += 1;
        }
    }
    let symbols = &mut symbols[..count];
    symbols.sort_unstable();
    if count < 2 {
        for &symbol in symbols.iter() {
            lengths[(symbol & 0xffff) as usize] = 1;
        }
        return;
    }

    // Huffman's construction with two queues: leaves in order, and nodes, which arise in order.
    // Node n of `parents` is leaf n below `count`, the inner node n - count above.
    let mut parents = [0_u16; 576];
    let mut weights = [0_u64; 288];
    let (mut leaf, mut node) = (0, 0);
    for made in 0..count - 1 {
        let mut weight = 0;
        for _ in 0..2 {
            let take_leaf = leaf < count && (node >= made || symbols[leaf] >> 16 <= weights[node]);
            if take_leaf {
                weight += symbols[leaf] >> 16;
                parents[leaf] = (count + made) as u16;
                leaf += 1;
            } else {
                weight += weights[node];
                parents[count + node] = (count + made) as u16;
                node += 1;
            }
        }
        weights[made] = weight;
    }
    // Depths from the root down; how many leaves each depth has.
    let root = 2 * count - 2;
    let mut depths = [0_u8; 576];
    let mut leaves = [0_u32; 64];
    for n in (0..root).rev() {
        depths[n] = depths[parents[n] as usize].saturating_add(1);
        if n < count {
            leaves[depths[n].min(63) as usize] += 1;
        }
    }

    // Leaves too deep go up to the limit, and the code is mended: with the sum of 2^(limit-depth)
    // over 2^limit, take a deepest leaf away and hang it beside another, one level further down.
    let limit = usize::from(limit);
    let beyond: u32 = leaves[limit + 1..].iter().sum();
    if beyond > 0 {
        leaves[limit] += beyond;
        let mut total: u32 = (1..=limit).map(|d| leaves[d] << (limit - d)).sum();
        while total > 1 << limit {
            leaves[limit] -= 1;
            let up = (1..limit).rev().find(|&d| leaves[d] > 0).unwrap_or(1);
            leaves[up] -= 1;
            leaves[up + 1] += 2;
            total -= 1;
        }
    }
    // The rarest symbols take the longest codes.
    let mut rest = symbols.iter();
    for depth in (1..=limit).rev() {
        for &symbol in rest.by_ref().take(leaves[depth] as usize) {
            lengths[(symbol & 0xffff) as usize] = depth as u8;
        }
    }
}

/// The canonical codes of these lengths, first bit lowest, as deflate's stream wants them.
pub(crate) fn codes(lengths: &[u8], codes: &mut [u16]) {
    let mut counts = [0_u16; 16];
    for &length in lengths {
        counts[usize::from(length)] += 1;
    }
    counts[0] = 0;
    let mut next = [0_u16; 16];
    for length in 1..16 {
        next[length] = (next[length - 1] + counts[length - 1]) << 1;
    }
    for (&length, code) in lengths.iter().zip(codes) {
        if length > 0 {
            *code = next[usize::from(length)].reverse_bits() >> (16 - length);
            next[usize::from(length)] += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kraft(lengths: &[u8]) -> f64 {
        let used = lengths.iter().filter(|&&length| length > 0);
        used.map(|&length| 0.5_f64.powi(length.into())).sum()
    }

    #[test]
    fn codes_are_complete_and_within_the_limit() {
        let mut frequencies = [0_u32; 286];
        let mut state = 1_u32;
        for case in 0..200 {
            for (i, f) in frequencies.iter_mut().enumerate() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *f = match case % 4 {
                    0 => state >> 20,
                    1 => (state >> 16) & (state >> 24) & 1,
                    2 => 1 << (i % 31),
                    _ => (state >> 8) >> (i % 24),
                };
            }
            for limit in [9, 12, 15] {
                let mut found = [0; 286];
                lengths(&frequencies, limit, &mut found);
                for (length, frequency) in found.iter().zip(frequencies) {
                    assert_eq!(*length > 0, frequency > 0);
                    assert!(*length <= limit);
                }
                assert_eq!(kraft(&found), 1.0);
            }
        }
    }

    #[test]
    fn rarer_symbols_have_longer_codes() {
        let mut found = [0; 6];
        lengths(&[45, 13, 12, 16, 9, 5], 15, &mut found);
        // The worked example of Cormen et al., "Introduction to Algorithms", 16.3.
        assert_eq!(found, [1, 3, 3, 3, 4, 4]);
        let mut bits = [0; 6];
        codes(&found, &mut bits);
        let text: Vec<u16> = (0..6).map(|s| bits[s].reverse_bits() >> (16 - found[s])).collect();
        assert_eq!(text, [0b0, 0b100, 0b101, 0b110, 0b1110, 0b1111]);
    }

    #[test]
    fn few_symbols() {
        let mut found = [9; 3];
        lengths(&[0, 0, 0], 7, &mut found);
        assert_eq!(found, [0, 0, 0]);
        lengths(&[0, 5, 0], 7, &mut found);
        assert_eq!(found, [0, 1, 0]);
        lengths(&[2, 5, 0], 7, &mut found);
        assert_eq!(found, [1, 1, 0]);
    }
}
