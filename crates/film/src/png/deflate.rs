//! Deflate for filtered rows (RFC 1951).
//!
//! The fast way: filtered rows of a render are small numbers and runs of zeros, so a band becomes
//! one block with a Huffman code of its own, literals, and matches of distance 1 within runs of
//! zeros. The other ways search for matches with `miniz_oxide`.

use super::huffman;
use crate::still::Compression;
use miniz_oxide::deflate::core::{
    CompressorOxide, TDEFLFlush, compress, create_comp_flags_from_zip_params,
};

const END: usize = 256;
const LITERALS_AND_LENGTHS: usize = 286;
/// So that four codes and the bits that wait fill at most a word.
const LONGEST_CODE: u8 = 12;
const LONGEST_MATCH: usize = 258;
/// Shorter runs are literals.
const SHORTEST_RUN: usize = 8;

/// The buffers of one worker.
#[derive(Default)]
pub(crate) struct Scratch {
    search: Option<(Compression, Box<CompressorOxide>)>,
}

/// Appends `data` as blocks, none of them final, and an empty stored block, which ends on a byte.
pub(crate) fn block(
    data: &[u8],
    compression: Compression,
    scratch: &mut Scratch,
    out: &mut Vec<u8>,
) {
    let level = match compression {
        Compression::Fast => return fast(data, out),
        Compression::Balanced => 4,
        Compression::Small => 9,
    };
    let fresh = || {
        // A negative window asks for a bare stream without a zlib header.
        let flags = create_comp_flags_from_zip_params(level, -15, 0);
        (compression, Box::new(CompressorOxide::new(flags)))
    };
    let (_, search) = match &mut scratch.search {
        Some(search) if search.0 == compression => {
            search.1.reset();
            search
        }
        search => search.insert(fresh()),
    };
    let start = out.len();
    let mut rest = data;
    loop {
        let filled = out.len();
        out.resize(filled + rest.len() / 2 + 1024, 0);
        let (_, read, written) = compress(search, rest, &mut out[filled..], TDEFLFlush::Sync);
        let room = out.len() - filled - written;
        out.truncate(filled + written);
        rest = &rest[read..];
        if rest.is_empty() && room > 0 {
            break;
        }
    }
    // What does not shrink is stored.
    if out.len() - start > stored_len(data.len()) {
        out.truncate(start);
        stored(data, out);
    }
}

const STORED_MOST: usize = 65535;

fn stored_len(len: usize) -> usize {
    len + 5 * (len.div_ceil(STORED_MOST) + 1)
}

/// Stored blocks and an empty one.
fn stored(data: &[u8], out: &mut Vec<u8>) {
    for piece in data.chunks(STORED_MOST).chain([&[][..]]) {
        let length = piece.len() as u16;
        out.push(0);
        out.extend_from_slice(&length.to_le_bytes());
        out.extend_from_slice(&(!length).to_le_bytes());
        out.extend_from_slice(piece);
    }
}

/// The symbol, its extra bits and their number, for a match of 3..=258 bytes (RFC 1951, 3.2.5).
const fn match_symbol(length: usize) -> (usize, u32, u32) {
    match length {
        258 => (285, 0, 0),
        3..=10 => (254 + length, 0, 0),
        _ => {
            // Four symbols to each number of extra bits: 11-18 have one, 19-34 two, and so on.
            let extra = (length - 3).ilog2() - 2;
            let group = 261 + 4 * extra as usize;
            let offset = length - 3 - (4 << extra);
            (group + (offset >> extra), (offset & ((1 << extra) - 1)) as u32, extra)
        }
    }
}

/// Takes the parts of a band in order.
trait Tokens {
    fn eight(&mut self, bytes: [u8; 8]);
    fn one(&mut self, byte: u8);
    /// A match of distance 1.
    fn repeat(&mut self, length: usize);
}

/// Cuts `data` into literals and, where eight zeros stand together, matches.
#[inline(always)]
fn scan(data: &[u8], tokens: &mut impl Tokens) {
    let mut at = 0;
    while let Some(bytes) = data.get(at..).and_then(|rest| rest.first_chunk::<8>()) {
        if u64::from_le_bytes(*bytes) != 0 {
            tokens.eight(*bytes);
            at += 8;
            continue;
        }
        let run = SHORTEST_RUN + zeros(&data[at + SHORTEST_RUN..]);
        at += run;
        // The first zero is what the matches repeat.
        tokens.one(0);
        let mut rest = run - 1;
        while rest >= LONGEST_MATCH {
            tokens.repeat(LONGEST_MATCH);
            rest -= LONGEST_MATCH;
        }
        if rest >= 3 {
            tokens.repeat(rest);
        } else {
            for _ in 0..rest {
                tokens.one(0);
            }
        }
    }
    for &byte in &data[at..] {
        tokens.one(byte);
    }
}

/// How many zeros `data` begins with.
#[inline(always)]
fn zeros(data: &[u8]) -> usize {
    let mut at = 0;
    while let Some(bytes) = data[at..].first_chunk::<8>() {
        let word = u64::from_le_bytes(*bytes);
        if word != 0 {
            return at + word.trailing_zeros() as usize / 8;
        }
        at += 8;
    }
    at + data[at..].iter().take_while(|&&byte| byte == 0).count()
}

/// Counts. Four histograms, so that equal neighbours do not wait for one another.
struct Histogram {
    literals: [[u32; 256]; 4],
    lengths: [u32; 30],
}

impl Tokens for Histogram {
    #[inline(always)]
    fn eight(&mut self, bytes: [u8; 8]) {
        for (i, byte) in bytes.into_iter().enumerate() {
            self.literals[i % 4][usize::from(byte)] += 1;
        }
    }

    #[inline(always)]
    fn one(&mut self, byte: u8) {
        self.literals[0][usize::from(byte)] += 1;
    }

    #[inline(always)]
    fn repeat(&mut self, length: usize) {
        self.lengths[match_symbol(length).0 - END] += 1;
    }
}

/// Bits, lowest first, into a buffer with room for eight bytes beyond what is written.
struct Bits<'a> {
    out: &'a mut [u8],
    at: usize,
    waiting: u64,
    count: u32,
}

impl Bits<'_> {
    /// Adds bits; together with those that wait, at most 64.
    #[inline(always)]
    fn add(&mut self, bits: u64, count: u32) {
        self.waiting |= bits << self.count;
        self.count += count;
    }

    /// Leaves at most 7 bits waiting. Wants at most 63 before.
    #[inline(always)]
    fn flush(&mut self) {
        self.out[self.at..self.at + 8].copy_from_slice(&self.waiting.to_le_bytes());
        self.at += (self.count / 8) as usize;
        self.waiting >>= self.count & !7;
        self.count &= 7;
    }

    #[inline(always)]
    fn put(&mut self, bits: u32, count: u32) {
        self.add(bits.into(), count);
        self.flush();
    }
}

/// A code and its length in the upper half.
type Entry = u32;

/// Writes.
struct Writer<'a> {
    bits: Bits<'a>,
    table: [Entry; 512],
}

impl Writer<'_> {
    #[inline(always)]
    fn four(&mut self, bytes: [u8; 4]) {
        let [a, b, c, d] = bytes.map(|byte| self.table[usize::from(byte)]);
        let pair = |low: Entry, high: Entry| {
            let count = low >> 16;
            (u64::from(low & 0xffff) | (u64::from(high & 0xffff) << count), count + (high >> 16))
        };
        let ((low, low_count), (high, high_count)) = (pair(a, b), pair(c, d));
        self.bits.add(low | (high << low_count), low_count + high_count);
        self.bits.flush();
    }

    #[inline(always)]
    fn symbol(&mut self, symbol: usize) {
        let entry = self.table[symbol];
        self.bits.put(entry & 0xffff, entry >> 16);
    }
}

impl Tokens for Writer<'_> {
    #[inline(always)]
    fn eight(&mut self, [a, b, c, d, e, f, g, h]: [u8; 8]) {
        self.four([a, b, c, d]);
        self.four([e, f, g, h]);
    }

    #[inline(always)]
    fn one(&mut self, byte: u8) {
        self.symbol(usize::from(byte));
    }

    #[inline(always)]
    fn repeat(&mut self, length: usize) {
        let (symbol, extra, extra_count) = match_symbol(length);
        self.symbol(symbol);
        // The distance 1 has the one-bit code 0.
        self.bits.put(extra, extra_count + 1);
    }
}

/// The order in which the lengths of the code for code lengths are sent (RFC 1951, 3.2.7).
const LENGTH_ORDER: [usize; 19] =
    [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/// The header of a dynamic block: its symbols for code lengths, each with extra bits, and the code
/// that they are sent in.
struct Header {
    literals: usize,
    symbols: Vec<(u8, u8)>,
    lengths: [u8; 19],
}

/// Extra bits of the symbols for code lengths.
fn length_extra(symbol: u8) -> u32 {
    match symbol {
        16 => 2,
        17 => 3,
        18 => 7,
        _ => 0,
    }
}

impl Header {
    fn new(lengths: &[u8; LITERALS_AND_LENGTHS]) -> Self {
        let literals = lengths.iter().rposition(|&length| length > 0).unwrap_or(END) + 1;
        let literals = literals.max(257);
        // One distance, code 0, of one bit.
        let sent: Vec<u8> = lengths[..literals].iter().copied().chain([1]).collect();
        let mut symbols = Vec::with_capacity(sent.len());
        for run in sent.chunk_by(|a, b| a == b) {
            let length = run[0];
            let mut rest = run.len();
            if length == 0 {
                while rest >= 11 {
                    let repeat = rest.min(138);
                    symbols.push((18, (repeat - 11) as u8));
                    rest -= repeat;
                }
                if rest >= 3 {
                    symbols.push((17, (rest - 3) as u8));
                    rest = 0;
                }
            } else {
                symbols.push((length, 0));
                rest -= 1;
                while rest >= 3 {
                    let repeat = rest.min(6);
                    symbols.push((16, (repeat - 3) as u8));
                    rest -= repeat;
                }
            }
            symbols.extend(std::iter::repeat_n((length, 0), rest));
        }
        let mut frequencies = [0; 19];
        for &(symbol, _) in &symbols {
            frequencies[usize::from(symbol)] += 1;
        }
        let mut lengths = [0; 19];
        huffman::lengths(&frequencies, 7, &mut lengths);
        Self { literals, symbols, lengths }
    }

    /// How many of the lengths in `LENGTH_ORDER` are sent.
    fn sent_lengths(&self) -> usize {
        let last = LENGTH_ORDER.iter().rposition(|&s| self.lengths[s] > 0);
        last.map_or(4, |last| (last + 1).max(4))
    }

    fn bits(&self) -> u64 {
        let symbols = self.symbols.iter();
        let symbols: u64 = symbols
            .map(|&(s, _)| u64::from(self.lengths[usize::from(s)]) + u64::from(length_extra(s)))
            .sum();
        3 + 5 + 5 + 4 + 3 * self.sent_lengths() as u64 + symbols
    }

    fn write(&self, bits: &mut Bits<'_>) {
        // Not final, dynamic.
        bits.put(0b100, 3);
        bits.put((self.literals - 257) as u32, 5);
        bits.put(0, 5);
        let sent = self.sent_lengths();
        bits.put(sent as u32 - 4, 4);
        for symbol in &LENGTH_ORDER[..sent] {
            bits.put(self.lengths[*symbol].into(), 3);
        }
        let mut codes = [0; 19];
        huffman::codes(&self.lengths, &mut codes);
        for &(symbol, extra) in &self.symbols {
            let at = usize::from(symbol);
            bits.put(codes[at].into(), self.lengths[at].into());
            bits.put(extra.into(), length_extra(symbol));
        }
    }
}

/// One dynamic block and an empty stored one, or stored blocks where that is shorter.
fn fast(data: &[u8], out: &mut Vec<u8>) {
    let mut histogram = Histogram { literals: [[0; 256]; 4], lengths: [0; 30] };
    scan(data, &mut histogram);
    let mut frequencies = [0_u32; LITERALS_AND_LENGTHS];
    for (byte, frequency) in frequencies[..256].iter_mut().enumerate() {
        *frequency = histogram.literals.iter().map(|counts| counts[byte]).sum();
    }
    frequencies[END..].copy_from_slice(&histogram.lengths);
    frequencies[END] = 1;
    let mut lengths = [0; LITERALS_AND_LENGTHS];
    huffman::lengths(&frequencies, LONGEST_CODE, &mut lengths);
    let header = Header::new(&lengths);

    let mut total = header.bits();
    for (symbol, (&frequency, &length)) in frequencies.iter().zip(&lengths).enumerate() {
        let extra = match symbol {
            265..285 => (symbol as u64 - 261) / 4 + 1,
            257.. => 1,
            _ => 0,
        };
        total += u64::from(frequency) * (u64::from(length) + extra);
    }
    // The empty block: 3 bits, up to a byte, and its length twice.
    let size = (total + 3).div_ceil(8) as usize + 4;
    if size >= stored_len(data.len()) {
        return stored(data, out);
    }

    let mut table = [0; 512];
    let mut codes = [0; LITERALS_AND_LENGTHS];
    huffman::codes(&lengths, &mut codes);
    for (entry, (&code, &length)) in table.iter_mut().zip(codes.iter().zip(&lengths)) {
        *entry = u32::from(code) | (u32::from(length) << 16);
    }
    let start = out.len();
    out.resize(start + size + 8, 0);
    let mut writer =
        Writer { bits: Bits { out: &mut out[start..], at: 0, waiting: 0, count: 0 }, table };
    header.write(&mut writer.bits);
    scan(data, &mut writer);
    writer.symbol(END);
    let bits = &mut writer.bits;
    debug_assert_eq!(bits.at as u64 * 8 + u64::from(bits.count), total);
    bits.put(0, 3);
    bits.put(0, bits.count.wrapping_neg() & 7);
    bits.put(0xffff_0000, 32);
    debug_assert_eq!(bits.at, size);
    out.truncate(start + size);
}

#[cfg(test)]
mod tests {
    use super::*;
    use miniz_oxide::inflate::decompress_to_vec;

    fn hold(data: &[u8]) -> usize {
        let mut sizes = Vec::new();
        for compression in [Compression::Fast, Compression::Balanced, Compression::Small] {
            let mut scratch = Scratch::default();
            let mut out = b"kept".to_vec();
            block(data, compression, &mut scratch, &mut out);
            assert!(out.ends_with(&[0, 0, 0xff, 0xff]));
            sizes.push(out.len() - 4);
            // Twice with the same buffers: the second must not lean on the first.
            let first = out.len();
            block(data, compression, &mut scratch, &mut out);
            assert_eq!(out[4..first], out[first..]);
            out.extend_from_slice(&[3, 0]);
            let twice = [data, data].concat();
            assert_eq!(decompress_to_vec(&out[4..]).unwrap(), twice);
        }
        sizes[0]
    }

    #[test]
    fn every_length_of_run_and_rest() {
        for length in 0..600 {
            hold(&vec![0; length]);
            let mut data = vec![7; length % 13];
            data.extend(std::iter::repeat_n(0, length));
            data.extend((0..length % 17).map(|i| i as u8));
            hold(&data);
        }
    }

    #[test]
    fn match_symbols_follow_the_table() {
        // RFC 1951, section 3.2.5: length, symbol, extra bits.
        for (length, symbol, extra) in [
            (3, 257, 0),
            (10, 264, 0),
            (11, 265, 1),
            (12, 265, 1),
            (13, 266, 1),
            (18, 268, 1),
            (19, 269, 2),
            (34, 272, 2),
            (35, 273, 3),
            (66, 276, 3),
            (67, 277, 4),
            (130, 280, 4),
            (131, 281, 5),
            (257, 284, 5),
            (258, 285, 0),
        ] {
            let found = match_symbol(length);
            assert_eq!((found.0, found.2), (symbol, extra), "{length}");
        }
        assert_eq!(match_symbol(257).1, 30);
    }

    #[test]
    fn data_of_every_kind() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 24
        };
        let noise: Vec<u8> = (0..200_000).map(|_| random() as u8).collect();
        assert!(hold(&noise) <= stored_len(noise.len()));
        let skewed: Vec<u8> = (0..70_000).map(|_| (random() & random() & random()) as u8).collect();
        assert!(hold(&skewed) < skewed.len() * 2 / 3);
        // Frequencies by powers of two ask for codes beyond the limit.
        let steep: Vec<u8> =
            (0..24_u32).flat_map(|i| vec![i as u8 + 1; 1 << (i * 3 / 4)]).collect();
        hold(&steep);
        hold(&vec![9; 100_000]);
        hold(b"");
        hold(b"a");
    }
}
