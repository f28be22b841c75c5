use crate::RemarkKind;
use crate::stream::tests::{Writer, columns, open, survives};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

impl Writer {
    fn doubles(self, values: &[f64]) -> Vec<u8> {
        values.iter().flat_map(|v| self.f64(*v)).collect()
    }

    fn element(self, kind: u32, content: &[u8]) -> Vec<u8> {
        let mut all = [
            self.u32(kind),
            self.u32(content.len() as u32),
            content.to_vec(),
        ]
        .concat();
        all.resize(all.len().next_multiple_of(8), 0);
        all
    }

    /// The elements of a matrix of some class.
    fn matrix(self, class: u32, name: &str, sizes: [u32; 2], parts: &[Vec<u8>]) -> Vec<u8> {
        let flags = [self.u32(class), self.u32(0)].concat();
        let sizes = [self.u32(sizes[0]), self.u32(sizes[1])].concat();
        let head = [
            self.element(6, &flags),
            self.element(5, &sizes),
            self.element(1, name.as_bytes()),
        ];
        self.element(14, &[head.concat(), parts.concat()].concat())
    }

    fn file(self, variables: &[Vec<u8>]) -> Vec<u8> {
        let mut head = b"MATLAB 5.0 MAT-file, written by somebody".to_vec();
        head.resize(124, b' ');
        head.extend(if self.big {
            *b"\x01\x00MI"
        } else {
            *b"\x00\x01IM"
        });
        [head, variables.concat()].concat()
    }
}

#[test]
fn known_variables_in_both_orders() {
    for w in [Writer { big: false }, Writer { big: true }] {
        let vector = w.matrix(
            6,
            "v",
            [1, 3],
            &[w.element(9, &w.doubles(&[1.0, 2.0, 3.0]))],
        );
        // Doubles that were stored as bytes, in a small element.
        let small = [w.u32(3 << 16 | 2), vec![7, 8, 9, 0]].concat();
        let bytes = w.matrix(6, "bytes", [3, 1], &[small]);
        let complex = w.matrix(
            6 | 0x800,
            "c",
            [2, 1],
            &[
                w.element(9, &w.doubles(&[1.0, 2.0])),
                w.element(9, &w.doubles(&[-1.0, -2.0])),
            ],
        );
        let field = w.matrix(
            6,
            "",
            [2, 2],
            &[w.element(9, &w.doubles(&[5.0, 6.0, 7.0, 8.0]))],
        );
        let inside = [
            w.u32(4 << 16 | 5),
            w.u32(8),
            w.element(1, b"acc\0\0\0\0\0"),
            field,
        ]
        .concat();
        let structure = w.matrix(2, "s", [1, 1], &[inside]);
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&structure).unwrap();
        let packed = packed.finish().unwrap();
        let packed = [w.u32(15), w.u32(packed.len() as u32), packed].concat();
        let word = w.matrix(4, "operator", [1, 3], &[w.element(16, b"abc")]);
        let file = w.file(&[vector, bytes, complex, packed, word]);
        let container = open(&file).unwrap();
        let names: Vec<Vec<&str>> = container
            .streams()
            .iter()
            .map(|s| s.channels.iter().map(|c| c.name.as_str()).collect())
            .collect();
        assert_eq!(names[0], ["v", "bytes"]);
        assert_eq!(
            names[1],
            ["c real", "c imaginary", "s.acc(:,1)", "s.acc(:,2)"]
        );
        assert!(container.remarks().is_empty(), "{:?}", container.remarks());
        assert_eq!(columns(container, 0), [[1.0, 2.0, 3.0], [7.0, 8.0, 9.0]]);
        let second = columns(open(&file).unwrap(), 1);
        assert_eq!(second, [[1.0, 2.0], [-1.0, -2.0], [5.0, 6.0], [7.0, 8.0]]);
        survives(&file);
        // A byte of the check sum.
        let mut damaged = file.clone();
        let at = damaged
            .windows(8)
            .rposition(|b| {
                b == w.matrix(4, "operator", [1, 3], &[w.element(16, b"abc")])[..8].to_vec()
            })
            .unwrap();
        damaged[at - 1] ^= 1;
        let container = open(&damaged).unwrap();
        assert_eq!(container.remarks()[0].kind, RemarkKind::Damaged);
        assert_eq!(container.streams()[1].channels.len(), 2);
    }
}

#[test]
fn known_matrices_of_level_4() {
    for (w, form) in [(Writer { big: false }, 0), (Writer { big: true }, 1000)] {
        let matrix = |name: &str, complex: u32, values: &[f64]| {
            [
                w.u32(form),
                w.u32(2),
                w.u32(1),
                w.u32(complex),
                w.u32(name.len() as u32 + 1),
                name.as_bytes().to_vec(),
                vec![0],
                w.doubles(values),
            ]
            .concat()
        };
        let file = [
            matrix("a", 0, &[1.0, 2.0]),
            matrix("b", 1, &[3.0, 4.0, 5.0, 6.0]),
        ]
        .concat();
        let container = open(&file).unwrap();
        assert_eq!(container.format().word, "mat4");
        assert_eq!(columns(container, 0), [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]);
        survives(&file);
    }
}
