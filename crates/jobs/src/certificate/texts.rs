//! Every word that a certificate prints, in every language: one row a text, so that one without a translation does not compile.

use serde::{Deserialize, Serialize};

/// Language of a certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Language {
    /// English.
    #[default]
    #[serde(rename = "en")]
    #[cfg_attr(feature = "clap", value(name = "en"))]
    English,
    /// Italian.
    #[serde(rename = "it")]
    #[cfg_attr(feature = "clap", value(name = "it"))]
    Italian,
    /// Persian, from right to left.
    #[serde(rename = "fa")]
    #[cfg_attr(feature = "clap", value(name = "fa"))]
    Persian,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::English, Self::Italian, Self::Persian];

    /// ISO 639-1.
    pub fn code(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::Italian => "it",
            Self::Persian => "fa",
        }
    }

    /// Direction of its writing, as in HTML.
    pub fn direction(self) -> &'static str {
        match self {
            Self::Persian => "rtl",
            _ => "ltr",
        }
    }
}

macro_rules! texts {
    ($($(#[$doc:meta])* $name:ident: $english:literal, $italian:literal, $persian:literal;)*) => {
        /// A text of a certificate.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Text {
            $($(#[$doc])* $name,)*
        }

        impl Text {
            /// All of them.
            #[cfg(test)]
            pub(crate) const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The text in a language; words in braces stand for what is put in.
            pub(crate) fn of(self, language: Language) -> &'static str {
                match (self, language) {
                    $((Self::$name, Language::English) => $english,
                    (Self::$name, Language::Italian) => $italian,
                    (Self::$name, Language::Persian) => $persian,)*
                }
            }
        }
    };
}

texts! {
    Title: "Calibration certificate", "Certificato di taratura", "گواهی کالیبراسیون";
    Draft: "DRAFT", "BOZZA", "پیش‌نویس";
    PageOf: "Page {page} of {pages}", "Pagina {page} di {pages}", "صفحهٔ {page} از {pages}";
    End: "End of the certificate", "Fine del certificato", "پایان گواهی";
    Number: "Certificate number", "Numero del certificato", "شمارهٔ گواهی";
    NoNumber: "draft, no number", "bozza, senza numero", "پیش‌نویس، بدون شماره";
    Laboratory: "Laboratory", "Laboratorio", "آزمایشگاه";
    Address: "Address", "Indirizzo", "نشانی";
    Place: "Place of calibration", "Luogo della taratura", "محل کالیبراسیون";
    AtLaboratory: "at the laboratory", "presso il laboratorio", "در آزمایشگاه";
    AtCustomer: "at the customer's premises", "presso il cliente", "در محل مشتری";
    Customer: "Customer", "Committente", "مشتری";
    Order: "Order", "Ordine", "سفارش";
    Item: "Item calibrated", "Oggetto della taratura", "دستگاه کالیبره‌شده";
    Object: "Object", "Oggetto", "نوع دستگاه";
    Accelerometer: "Accelerometer", "Accelerometro", "شتاب‌سنج";
    Manufacturer: "Manufacturer", "Costruttore", "سازنده";
    Model: "Type", "Modello", "مدل";
    Serial: "Serial number", "Numero di matricola", "شمارهٔ سریال";
    CustomerId: "Identification by the customer", "Identificazione del committente", "شناسهٔ مشتری";
    Condition: "Condition on receipt", "Condizioni al ricevimento", "وضعیت هنگام تحویل";
    Received: "Date of receipt", "Data di ricevimento", "تاریخ تحویل";
    Calibrated: "Date of calibration", "Data della taratura", "تاریخ کالیبراسیون";
    Issued: "Date of issue", "Data di emissione", "تاریخ صدور";
    Due: "Next calibration, at the request of the customer", "Prossima taratura, su richiesta del committente", "کالیبراسیون بعدی، به درخواست مشتری";
    Method: "Method", "Metodo", "روش";
    Procedure: "Procedure", "Procedura", "روش اجرا";
    Deviations: "Deviations from the method", "Scostamenti dal metodo", "انحراف از روش";
    Mounting: "Mounting of the item", "Montaggio dell'oggetto", "نصب دستگاه";
    Amplitude: "Amplitude of the acceleration", "Ampiezza dell'accelerazione", "دامنهٔ شتاب";
    CalibratedOver: "Temperatures of the item", "Temperature dell'oggetto", "دماهای دستگاه";
    ReferenceTemperature: "Reference temperature T₀ of the temperature terms", "Temperatura di riferimento T₀ dei termini di temperatura", "دمای مرجع T₀ جمله‌های دمایی";
    Accreditation: "Accreditation", "Accreditamento", "اعتباربخشی";
    Environment: "Environmental conditions", "Condizioni ambientali", "شرایط محیطی";
    Temperature: "Temperature", "Temperatura", "دما";
    Humidity: "Relative humidity", "Umidità relativa", "رطوبت نسبی";
    Conditions: "Further conditions", "Altre condizioni", "شرایط دیگر";
    Traceability: "Metrological traceability", "Riferibilità metrologica", "ردیابی اندازه‌شناختی";
    TraceabilityStatement: "The results are traceable to the SI through the standards named below, each with its own calibration certificate.",
        "I risultati sono riferibili al SI mediante i campioni elencati di seguito, ciascuno con il proprio certificato di taratura.",
        "نتایج از راه استانداردهای زیر، هر یک با گواهی کالیبراسیون خود، به دستگاه بین‌المللی یکاها (SI) ردیابی‌پذیرند.";
    GravityStatement: "The reference is the local acceleration due to gravity: normal gravity of the ellipsoid GRS 80 (Moritz, 2000) at the latitude {latitude} and the height {height}: {g} with the standard uncertainty {u}.",
        "Il riferimento è l'accelerazione di gravità locale: gravità normale dell'ellissoide GRS 80 (Moritz, 2000) alla latitudine {latitude} e alla quota {height}: {g} con incertezza tipo {u}.",
        "مرجع، شتاب گرانش محلی است: گرانش نرمال بیضوی GRS 80 (Moritz, 2000) در عرض جغرافیایی {latitude} و ارتفاع {height}، برابر با {g} با عدم قطعیت استاندارد {u}.";
    Standard: "Standard", "Campione", "استاندارد";
    CertificateOfStandard: "Certificate", "Certificato", "گواهی";
    IssuedBy: "Issued by", "Emesso da", "صادرکننده";
    ValidUntil: "Valid until", "Valido fino al", "معتبر تا";
    Results: "Results", "Risultati", "نتایج";
    AsFound: "As found", "Come trovato", "وضعیت دریافت (پیش از تنظیم)";
    AsLeft: "As left", "Come lasciato", "وضعیت تحویل (پس از تنظیم)";
    SensitivityOverFrequency: "Sensitivity over frequency", "Sensibilità in funzione della frequenza", "حساسیت بر حسب بسامد";
    SensitivityElement: "Sensitivity {element}: output along {output}, acceleration along {axis}", "Sensibilità {element}: uscita lungo {output}, accelerazione lungo {axis}", "حساسیت {element}: خروجی در راستای {output}، شتاب در راستای {axis}";
    TransverseOverFrequency: "Transverse sensitivity over frequency", "Sensibilità trasversale in funzione della frequenza", "حساسیت عرضی بر حسب بسامد";
    Parameters: "Parameters", "Parametri", "پارامترها";
    Quantity: "Quantity", "Grandezza", "کمیت";
    Value: "Value", "Valore", "مقدار";
    Unit: "Unit", "Unità", "یکا";
    Frequency: "Frequency", "Frequenza", "بسامد";
    Modulus: "Sensitivity", "Sensibilità", "حساسیت";
    Phase: "Phase", "Fase", "فاز";
    RelativePhase: "Phase relative to the reference", "Fase rispetto al riferimento", "فاز نسبت به مرجع";
    OwnPhase: "Phase among the axes", "Fase tra gli assi", "فاز میان محورها";
    RelativePhaseStatement: "The calibration of the reference states no phase: phases are those of the item relative to the reference, whose own phase is neither in their values nor in their uncertainties.",
        "La taratura del riferimento non riporta la fase: le fasi sono quelle dell'oggetto rispetto al riferimento, la cui fase propria non è compresa né nei valori né nelle incertezze.",
        "کالیبراسیون مرجع فازی بیان نمی‌کند: فازها نسبت به مرجع‌اند و فاز خود مرجع نه در مقدار آن‌هاست و نه در عدم قطعیت آن‌ها.";
    OwnPhaseStatement: "The item samples by a clock of its own: phases are those among its axes, counted from that of the first axis, and not against the reference.",
        "L'oggetto campiona con un proprio orologio: le fasi sono quelle tra i suoi assi, contate da quella del primo asse, e non rispetto al riferimento.",
        "دستگاه با ساعت خود نمونه‌برداری می‌کند: فازها میان محورهای آن و نسبت به محور نخست‌اند و نه نسبت به مرجع.";
    TransverseSensitivity: "Transverse sensitivity", "Sensibilità trasversale", "حساسیت عرضی";
    Angle: "Direction", "Direzione", "جهت";
    Bias: "Output at zero acceleration", "Uscita ad accelerazione nulla", "خروجی در شتاب صفر";
    ScaleFactor: "Scale factor", "Fattore di scala", "ضریب مقیاس";
    Misalignment: "Misalignment", "Disallineamento", "ناهم‌راستایی";
    Gravity: "Local acceleration of free fall", "Accelerazione di gravità locale", "شتاب گرانش محلی";
    TemperatureCoefficient: "Temperature term", "Termine di temperatura", "جملهٔ دمایی";
    CurvatureTerm: "Second-order term", "Termine del secondo ordine", "جملهٔ مرتبهٔ دوم";
    OtherQuantity: "Quantity of the result", "Grandezza del risultato", "کمیت نتیجه";
    PlotCaption: "{what}; bars: expanded uncertainty", "{what}; barre: incertezza estesa", "{what}؛ میله‌ها: عدم قطعیت گسترده";
    TableLabel: "Table {n}", "Tabella {n}", "جدول {n}";
    FigureLabel: "Figure {n}", "Figura {n}", "شکل {n}";
    UncertaintyTitle: "Uncertainty of measurement", "Incertezza di misura", "عدم قطعیت اندازه‌گیری";
    UncertaintyStatement: "The reported uncertainty is the expanded uncertainty U: the standard uncertainty multiplied by the coverage factor k stated beside it, for a coverage probability of {probability}. It was evaluated according to JCGM 100 (GUM). It refers to the conditions and the time of the calibration and includes no long-term drift of the item.",
        "L'incertezza dichiarata è l'incertezza estesa U: l'incertezza tipo moltiplicata per il fattore di copertura k riportato accanto, per una probabilità di copertura di {probability}. È stata valutata secondo JCGM 100 (GUM). Si riferisce alle condizioni e al momento della taratura e non comprende derive a lungo termine dell'oggetto.",
        "عدم قطعیت بیان‌شده، عدم قطعیت گسترده U است: عدم قطعیت استاندارد ضرب در ضریب پوشش k که در کنار آن آمده است، برای احتمال پوشش {probability}. ارزیابی آن بر پایهٔ JCGM 100 (GUM) انجام شده است. این مقدار به شرایط و زمان کالیبراسیون مربوط است و رانش درازمدت دستگاه را در بر نمی‌گیرد.";
    RoundingStatement: "U is rounded up to two significant digits; the value is rounded to the same decimal place.",
        "U è arrotondata per eccesso a due cifre significative; il valore è arrotondato alla stessa cifra decimale.",
        "مقدار U به سوی بالا تا دو رقم بامعنا گرد شده است؛ مقدار کمیت نیز تا همان رقم گرد شده است.";
    IntervalStatement: "Where an interval is stated, it is not symmetric about the value.", "Dove è indicato un intervallo, esso non è simmetrico rispetto al valore.", "هر جا بازه‌ای آمده است، آن بازه نسبت به مقدار متقارن نیست.";
    CovarianceStatement: "The covariance between the quantities and between the frequencies stands in the result that is embedded in the digital certificate.",
        "La covarianza tra le grandezze e tra le frequenze è riportata nel risultato incorporato nel certificato digitale.",
        "کوواریانس میان کمیت‌ها و میان بسامدها در نتیجهٔ جاسازی‌شده در گواهی دیجیتال آمده است.";
    TemperatureTerms: "Temperature terms: the change of the output of an axis at rest is T1 (T − T₀) + T2 (T − T₀)² + T3 (T − T₀)³; the term without a number is its mean slope over the temperatures of the item.",
        "Termini di temperatura: la variazione dell'uscita di un asse a riposo è T1 (T − T₀) + T2 (T − T₀)² + T3 (T − T₀)³; il termine senza numero è la sua pendenza media sulle temperature dell'oggetto.",
        "جمله‌های دمایی: تغییر خروجی یک محور در حال سکون برابر است با T1 (T − T₀) + T2 (T − T₀)² + T3 (T − T₀)³؛ جملهٔ بدون شماره شیب میانگین آن در بازهٔ دماهای دستگاه است.";
    ParametersOfModel: "Parameters: the output is K a + b, with the acceleration a along the axes x, y, z of the item; the scale factors are the diagonal of K, a misalignment ij is the element of K in row i and column j over the scale factor i, an angle in radians, and b is the output at zero acceleration.",
        "Parametri: l'uscita è K a + b, con l'accelerazione a lungo gli assi x, y, z dell'oggetto; i fattori di scala sono la diagonale di K, un disallineamento ij è l'elemento di K nella riga i e colonna j diviso per il fattore di scala i, un angolo in radianti, e b è l'uscita ad accelerazione nulla.",
        "پارامترها: خروجی برابر است با K a + b که در آن a شتاب در راستای محورهای x، y، z دستگاه است؛ ضریب‌های مقیاس قطر K هستند، ناهم‌راستایی ij درایهٔ سطر i و ستون j از K بخش بر ضریب مقیاس i است (زاویه بر حسب رادیان) و b خروجی در شتاب صفر است.";
    Conformity: "Statement of conformity", "Dichiarazione di conformità", "بیان انطباق";
    Rule: "Decision rule", "Regola decisionale", "قاعدهٔ تصمیم";
    SimpleRule: "simple acceptance: the measured value lies within the limits (JCGM 106, 8.2). The probability of a wrong decision may be up to 50 % at a limit.",
        "accettazione semplice: il valore misurato è entro i limiti (JCGM 106, 8.2). La probabilità di una decisione errata può arrivare al 50 % in corrispondenza di un limite.",
        "پذیرش ساده: مقدار اندازه‌گیری‌شده درون حدود است (JCGM 106، بند 8.2). احتمال تصمیم نادرست روی حد می‌تواند تا 50 % برسد.";
    GuardRule: "guard band w = r·U with r = {r}: the measured value lies within the limits narrowed by w (JCGM 106, 8.3).",
        "banda di guardia w = r·U con r = {r}: il valore misurato è entro i limiti ristretti di w (JCGM 106, 8.3).",
        "نوار محافظ w = r·U با r = {r}: مقدار اندازه‌گیری‌شده درون حدودی است که به اندازهٔ w تنگ‌تر شده‌اند (JCGM 106، بند 8.3).";
    LowerLimit: "Lower limit", "Limite inferiore", "حد پایین";
    LimitsFrom: "Source of the limits", "Origine dei limiti", "منبع حدود";
    UpperLimit: "Upper limit", "Limite superiore", "حد بالا";
    Decision: "Decision", "Decisione", "تصمیم";
    Pass: "pass", "conforme", "منطبق";
    Fail: "fail", "non conforme", "نامنطبق";
    Risk: "Probability that the decision is wrong", "Probabilità di decisione errata", "احتمال نادرستی تصمیم";
    Replaces: "This certificate replaces certificate {number}. Reason: {reason}", "Questo certificato sostituisce il certificato {number}. Motivo: {reason}", "این گواهی جایگزین گواهی {number} است. دلیل: {reason}";
    Validity: "The results relate only to the item calibrated, in the condition in which it was received. The certificate may be reproduced only in full, unless the laboratory agrees in writing.",
        "I risultati si riferiscono esclusivamente all'oggetto tarato, nelle condizioni in cui è stato ricevuto. Il certificato può essere riprodotto solo integralmente, salvo approvazione scritta del laboratorio.",
        "نتایج تنها به دستگاه کالیبره‌شده در وضعیت تحویل آن مربوط است. تکثیر این گواهی جز به‌طور کامل، بدون موافقت کتبی آزمایشگاه مجاز نیست.";
    Remarks: "Remarks", "Osservazioni", "ملاحظات";
    Authorised: "Authorised by", "Autorizzato da", "تأییدکننده";
    Evidence: "Result", "Risultato", "نتیجه";
    DraftNotice: "Draft: not a certificate, must not be handed over.", "Bozza: non è un certificato e non può essere consegnata.", "پیش‌نویس: این سند گواهی نیست و نباید تحویل داده شود.";
    ByComparison: "Calibration by comparison with a reference accelerometer on a shaker (ISO 16063-21)", "Taratura per confronto con un accelerometro di riferimento su vibratore (ISO 16063-21)", "کالیبراسیون با مقایسه با شتاب‌سنج مرجع روی لرزاننده (ISO 16063-21)";
    ByInterferometer: "Primary calibration by laser interferometry (ISO 16063-11)", "Taratura primaria mediante interferometria laser (ISO 16063-11)", "کالیبراسیون اولیه با تداخل‌سنجی لیزری (ISO 16063-11)";
    TriaxialShaker: "Calibration of a triaxial accelerometer on a shaker with a reference accelerometer, complex sensitivity matrix (ISO 16063-21)", "Taratura di un accelerometro triassiale su vibratore con accelerometro di riferimento, matrice di sensibilità complessa (ISO 16063-21)", "کالیبراسیون شتاب‌سنج سه‌محوره روی لرزاننده با شتاب‌سنج مرجع، ماتریس حساسیت مختلط (ISO 16063-21)";
    TransverseMethod: "Transverse sensitivity by vibration across the sensitive axis (ISO 16063-31)", "Sensibilità trasversale mediante vibrazione trasversale all'asse sensibile (ISO 16063-31)", "حساسیت عرضی با ارتعاش عمود بر محور حساس (ISO 16063-31)";
    ByGravity: "Static calibration against local gravity in many positions", "Taratura statica rispetto alla gravità locale in più posizioni", "کالیبراسیون ایستا نسبت به گرانش محلی در چند وضعیت";
    OverTemperature: "Calibration at rest over temperature", "Taratura a riposo in funzione della temperatura", "کالیبراسیون در حال سکون بر حسب دما";
    StaticTestMethod: "Static test against local gravity", "Prova statica rispetto alla gravità locale", "آزمون ایستا نسبت به گرانش محلی";
}

impl Text {
    /// The text with words in the place of braces.
    pub(crate) fn with(self, language: Language, words: &[(&str, &str)]) -> String {
        let pieces = self.pieces(language);
        let said = pieces.map(|piece| match piece {
            Piece::Text(text) => text,
            Piece::Word(name) => words.iter().find(|w| w.0 == name).map_or("", |w| w.1),
        });
        said.collect()
    }

    /// The text taken apart at its braces, once, so that what is put in is not looked at again.
    pub(crate) fn pieces(self, language: Language) -> impl Iterator<Item = Piece> {
        let mut parts = self.of(language).split('{');
        let first = parts.next().map(Piece::Text);
        let rest = parts.flat_map(|part| {
            let (name, text) = part.split_once('}').unwrap_or((part, ""));
            [Piece::Word(name), Piece::Text(text)]
        });
        first.into_iter().chain(rest)
    }
}

/// A piece of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    /// Words of ours.
    Text(&'static str),
    /// The name of what stands there.
    Word(&'static str),
}

/// A number with the digits and the decimal mark of Persian.
pub(crate) fn persian_digits(text: &str) -> String {
    let mut out = String::with_capacity(2 * text.len());
    let all: Vec<char> = text.chars().collect();
    for (i, c) in all.iter().enumerate() {
        let digit = |k: Option<&char>| k.is_some_and(char::is_ascii_digit);
        match c {
            '0'..='9' => out.extend(char::from_u32(0x06F0 + (*c as u32 - '0' as u32))),
            '.' if i > 0 && digit(all.get(i - 1)) && digit(all.get(i + 1)) => out.push('\u{066B}'),
            '%' => out.push('٪'),
            c => out.push(*c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// The words in braces of a text.
    fn braces(text: &str) -> BTreeSet<&str> {
        let parts = text.split('{').skip(1);
        parts.filter_map(|p| p.split('}').next()).collect()
    }

    #[test]
    fn law_every_text_is_translated_and_takes_the_same_words() {
        for text in Text::ALL {
            let [en, it, fa] = Language::ALL.map(|l| text.of(l));
            assert_eq!(braces(en), braces(it), "{text:?}");
            assert_eq!(braces(en), braces(fa), "{text:?}");
            assert!(en != it && en != fa, "{text:?} is not translated");
            let persian = |c: char| ('\u{600}'..='\u{6ff}').contains(&c);
            assert!(fa.chars().any(persian), "{text:?}: {fa}");
            assert!(
                !en.chars().any(persian) && !it.chars().any(persian),
                "{text:?}"
            );
        }
    }

    #[test]
    fn law_what_is_put_in_is_not_looked_at_again() {
        let said = Text::Replaces.with(
            Language::English,
            &[("number", "{reason}"), ("reason", "x")],
        );
        assert!(said.ends_with("certificate {reason}. Reason: x"), "{said}");
    }

    #[test]
    fn known_persian_digits() {
        assert_eq!(persian_digits("−9.8067"), "−۹٫۸۰۶۷");
        assert_eq!(persian_digits("2026-11-27."), "۲۰۲۶-۱۱-۲۷.");
        assert_eq!(persian_digits("95 %"), "۹۵ ٪");
    }
}
