//! The row of a parameter, and the macro that makes a struct out of rows.

/// What a parameter changes: the simulation's numbers, or only how they are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// Changes what is simulated.
    Simulation,
    /// Changes only how the result is shown.
    Appearance,
}

/// A parameter's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A real number.
    Real(f64),
    /// A whole number.
    Count(u32),
    /// A lower and an upper bound.
    Span([f64; 2]),
}

impl core::fmt::Display for Value {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Real(x) => write!(f, "{x}"),
            Self::Count(n) => write!(f, "{n}"),
            Self::Span([low, high]) => write!(f, "[{low}, {high}]"),
        }
    }
}

/// A Rust type that a parameter's value can have.
pub trait Kind: Copy {
    /// The value as the table of parameters shows it.
    fn to_value(self) -> Value;
    /// The value back, if it is of this kind.
    fn from_value(value: Value) -> Option<Self>;
}

impl Kind for f64 {
    fn to_value(self) -> Value {
        Value::Real(self)
    }
    fn from_value(value: Value) -> Option<Self> {
        match value {
            Value::Real(x) => Some(x),
            Value::Count(n) => Some(f64::from(n)),
            Value::Span(_) => None,
        }
    }
}

impl Kind for u32 {
    fn to_value(self) -> Value {
        Value::Count(self)
    }
    fn from_value(value: Value) -> Option<Self> {
        match value {
            Value::Count(n) => Some(n),
            _ => None,
        }
    }
}

impl Kind for [f64; 2] {
    fn to_value(self) -> Value {
        Value::Span(self)
    }
    fn from_value(value: Value) -> Option<Self> {
        match value {
            Value::Span(x) => Some(x),
            _ => None,
        }
    }
}

/// Everything there is to know of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Name in files and, with dashes, on the command line.
    pub id: &'static str,
    /// The paper's symbol.
    pub symbol: &'static str,
    /// Name for people.
    pub label: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value when nothing is said.
    pub default: Value,
    /// Values outside are refused.
    pub hard: (f64, f64),
    /// Values a slider offers.
    pub soft: (f64, f64),
    /// Whether it changes the simulation or only its picture.
    pub acts: Acts,
    /// What it does; the first sentence is the tooltip.
    pub doc: &'static str,
    /// Where the parameter and its default come from.
    pub source: &'static str,
}

impl Row {
    /// The value back if it is allowed, else why it is not.
    ///
    /// # Errors
    /// The value is not finite, outside the hard range, or an upside-down span.
    pub fn check(&self, value: Value) -> Result<Value, String> {
        let (low, high) = self.hard;
        let inside = |x: f64| {
            if x.is_finite() && (low..=high).contains(&x) {
                Ok(())
            } else {
                Err(format!("`{}` is {x}, outside {low} to {high}", self.id))
            }
        };
        match value {
            Value::Real(x) => inside(x)?,
            Value::Count(n) => inside(f64::from(n))?,
            Value::Span([a, b]) => {
                inside(a)?;
                inside(b)?;
                if a > b {
                    return Err(format!("`{}` is [{a}, {b}]: its lower bound is above its upper", self.id));
                }
            }
        }
        Ok(value)
    }

    /// Reads a value of this row's kind from text, as the command line gives it.
    ///
    /// # Errors
    /// The text is not such a value, or the value is not allowed.
    pub fn parse(&self, text: &str) -> Result<Value, String> {
        let real = |t: &str| t.trim().parse::<f64>().map_err(|_| format!("`{t}` is not a number"));
        let value = match self.default {
            Value::Real(_) => Value::Real(real(text)?),
            Value::Count(_) => {
                Value::Count(text.trim().parse().map_err(|_| format!("`{text}` is not a whole number"))?)
            }
            Value::Span(_) => match text.trim_matches(['[', ']']).split_once(',') {
                Some((a, b)) => Value::Span([real(a)?, real(b)?]),
                None => return Err(format!("`{text}` is not a pair such as 0.3,0.9")),
            },
        };
        self.check(value)
    }

    /// The first sentence of the doc.
    pub fn tooltip(&self) -> &'static str {
        self.doc.split_inclusive(". ").next().unwrap_or(self.doc).trim_end()
    }
}

/// A struct made of rows by [`parameters!`](crate::parameters).
pub trait Parameters: Default + Clone {
    /// The rows, in the order of the fields.
    const ROWS: &'static [Row];
    /// The value of a parameter.
    fn get(&self, id: &str) -> Option<Value>;
    /// Sets a parameter.
    ///
    /// # Errors
    /// No row has this id, or the value is of another kind or not allowed.
    fn set(&mut self, id: &str, value: Value) -> Result<(), String>;
}

/// Makes a struct of parameters, its defaults and its rows from one list.
///
/// ```
/// girtin_params::parameters! {
///     /// How the kettle boils.
///     pub struct Kettle {
///         heat: f64 {
///             symbol: "h", label: "Heat", unit: "kW", default: 2.0, hard: (0.0, 3.0), soft: (1.0, 2.0),
///             acts: Simulation, doc: "Power of the plate.", source: "measured",
///         }
///     }
/// }
/// assert_eq!(Kettle::default().heat, 2.0);
/// ```
#[macro_export]
macro_rules! parameters {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $($id:ident : $kind:tt {
                symbol: $symbol:literal, label: $label:literal, unit: $unit:literal, default: $default:expr,
                hard: $hard:expr, soft: $soft:expr, acts: $acts:ident, doc: $doc:literal, source: $source:literal $(,)?
            })*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $(#[doc = $doc] #[doc = concat!("\n\nUnit: ", $unit, ". Source: ", $source, ".")] pub $id: $kind,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($id: $default,)* }
            }
        }

        impl $crate::row::Parameters for $name {
            const ROWS: &'static [$crate::Row] = &[$($crate::Row {
                id: stringify!($id), symbol: $symbol, label: $label, unit: $unit,
                default: $crate::parameters!(@value $kind, $default),
                hard: $hard, soft: $soft, acts: $crate::Acts::$acts, doc: $doc, source: $source,
            },)*];

            fn get(&self, id: &str) -> Option<$crate::Value> {
                match id {
                    $(stringify!($id) => Some($crate::row::Kind::to_value(self.$id)),)*
                    _ => None,
                }
            }

            fn set(&mut self, id: &str, value: $crate::Value) -> Result<(), String> {
                let row = Self::ROWS.iter().find(|row| row.id == id).ok_or_else(|| format!("no parameter `{id}`"))?;
                let value = row.check(value)?;
                match id {
                    $(stringify!($id) => match $crate::row::Kind::from_value(value) {
                        Some(value) => { self.$id = value; Ok(()) }
                        None => Err(format!("`{id}` cannot be {value}")),
                    },)*
                    _ => Err(format!("no parameter `{id}`")),
                }
            }
        }
    };
    (@value f64, $default:expr) => { $crate::Value::Real($default) };
    (@value u32, $default:expr) => { $crate::Value::Count($default) };
    (@value [f64; 2], $default:expr) => { $crate::Value::Span($default) };
}

#[cfg(test)]
mod tests {
    use super::*;

    parameters! {
        /// Parameters to test with.
        pub struct Kettle {
            heat: f64 {
                symbol: "h", label: "Heat", unit: "kW", default: 2.0, hard: (0.0, 3.0), soft: (1.0, 2.0),
                acts: Simulation, doc: "Power of the plate. Not that of the fire.", source: "measured",
            }
            cups: u32 {
                symbol: "n", label: "Cups", unit: "", default: 4, hard: (1.0, 9.0), soft: (1.0, 4.0),
                acts: Appearance, doc: "How many.", source: "custom",
            }
            fill: [f64; 2] {
                symbol: "f", label: "Fill", unit: "1", default: [0.2, 0.8], hard: (0.0, 1.0), soft: (0.0, 1.0),
                acts: Simulation, doc: "From and to.", source: "custom",
            }
        }
    }

    #[test]
    fn defaults_are_inside_their_ranges() {
        for row in Kettle::ROWS {
            row.check(row.default).unwrap();
            assert_eq!(Kettle::default().get(row.id), Some(row.default));
        }
    }

    #[test]
    fn values_out_of_range_and_of_another_kind_are_refused() {
        let mut kettle = Kettle::default();
        assert!(kettle.set("heat", Value::Real(4.0)).is_err());
        assert!(kettle.set("heat", Value::Real(f64::NAN)).is_err());
        assert!(kettle.set("cups", Value::Real(1.5)).is_err());
        assert!(kettle.set("fill", Value::Span([0.9, 0.1])).is_err());
        assert!(kettle.set("lid", Value::Count(1)).is_err());
        assert_eq!(kettle, Kettle::default());
        kettle.set("fill", Value::Span([0.1, 0.9])).unwrap();
        assert_eq!(kettle.fill, [0.1, 0.9]);
    }

    #[test]
    fn text_becomes_a_value_of_the_rows_kind() {
        assert_eq!(Kettle::ROWS[0].parse("1.5"), Ok(Value::Real(1.5)));
        assert_eq!(Kettle::ROWS[1].parse("3"), Ok(Value::Count(3)));
        assert_eq!(Kettle::ROWS[2].parse("0.1, 0.4"), Ok(Value::Span([0.1, 0.4])));
        assert!(Kettle::ROWS[1].parse("3.5").is_err());
        assert_eq!(Kettle::ROWS[0].tooltip(), "Power of the plate.");
    }
}
