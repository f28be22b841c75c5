use crate::stream::tests::{columns, open, survives};
use crate::{Clock, RemarkKind};

#[test]
fn known_columns_of_different_step_and_length() {
    let file = "LabVIEW Measurement\t\r\nSeparator\tTab\r\nDecimal_Separator\t,\r\nX_Columns\tNo\r\nOperator\tsomebody\r\n\
        ***End_of_Header***\t\r\n\t\r\nChannels\t3\r\nSamples\t2\t3\t3\r\nY_Unit_Label\tg\tV\tV\r\n\
        X_Dimension\tTime\tTime\tTime\r\nX0\t0,0\t0,0\t0,0\r\nDelta_X\t0,5\t0,25\t0,25\r\n\
        ***End_of_Header***\t\t\t\r\nX_Value\ta\tb\tc\tComment\r\n\
        \t1,5\t10\t-1\tx\r\n\t2,5\t20\t-2\r\n\t\t30\t-3\r\n";
    let container = open(file.as_bytes()).unwrap();
    let seen: Vec<_> = container
        .streams()
        .iter()
        .map(|s| (s.name.as_str(), s.rows, s.channels.len(), s.clock))
        .collect();
    assert_eq!(
        seen,
        [
            (
                "every 0.5 s",
                2,
                1,
                Clock::Rate {
                    hz: 2.0,
                    start_s: 0.0
                }
            ),
            (
                "every 0.25 s",
                3,
                2,
                Clock::Rate {
                    hz: 4.0,
                    start_s: 0.0
                }
            ),
        ]
    );
    assert!(container.remarks().is_empty());
    assert_eq!(
        columns(container, 1),
        [[10.0, 20.0, 30.0], [-1.0, -2.0, -3.0]]
    );
    survives(file.as_bytes());
}

#[test]
fn known_times_of_their_own_and_segments() {
    let segment = "Channels,1\nSamples,2\nX0,0\nDelta_X,1\n***End_of_Header***\nX_Value,a,Comment\n0.0,1,\n1.3,2,late\n";
    let head = "LabVIEW Measurement,\nSeparator,Comma\nX_Columns,One\n***End_of_Header***\n\n";
    let file = format!("{head}{segment}\n{}", segment.replace("1.3", "1.0"));
    let container = open(file.as_bytes()).unwrap();
    let seen: Vec<_> = container
        .streams()
        .iter()
        .map(|s| (s.name.as_str(), s.clock))
        .collect();
    assert_eq!(
        seen,
        [
            ("segment 1", Clock::Times),
            (
                "segment 2, every 1 s",
                Clock::Rate {
                    hz: 1.0,
                    start_s: 0.0
                }
            ),
        ]
    );
    assert_eq!(columns(container, 0), [[1.0, 2.0], [0.0, 1.3]]);
    survives(file.as_bytes());
    let each = "LabVIEW Measurement,\nSeparator,Comma\nX_Columns,Multi\n***End_of_Header***\n\nChannels,2\nSamples,3,1\nDelta_X,0.5,0.5\n***End_of_Header***\nX_Value,a,X_Value,b\n0,1,0,10\n0.5,2\n";
    let container = open(each.as_bytes()).unwrap();
    assert_eq!(container.streams().len(), 2);
    assert_eq!(container.remarks()[0].kind, RemarkKind::Cut);
    assert_eq!(columns(container, 0), [[1.0, 2.0]]);
}
