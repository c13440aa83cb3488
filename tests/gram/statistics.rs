//! Statistics of least squares, against R's and statsmodels' on public data sets.
//!
//! The right values were computed with 60 digits (mpmath 1.3) from the numbers of the tables as
//! f64; `lm` of R and OLS and WLS of statsmodels 0.14 agree with them to the digits that they have.
//! `common/tables/mtcars.csv` is R's `mtcars` (Motor Trend, 1974); Longley is NIST's.

use catamaran::base::Rng;
use catamaran::faer::{Mat, MatRef, mat};
use catamaran::rows::{
    Accumulator, Center, DenseRows, Design, DesignColumn, Factor, RowBounds, RowOptions, Survey,
    ata_extended,
};
use catamaran::solve::{Interval, LeastSquares, LeastSquaresOptions, lstsq};
use catamaran::{AtaOptions, Error, Par};

use super::column;
use super::nist::NistSet;

const MTCARS: &str = include_str!("../common/tables/mtcars.csv");

/// Tables that statsmodels, scikit-learn and R package; the target is the first column.
const TABLES: [(&str, &str); 8] = [
    ("ccard", include_str!("../common/tables/ccard.csv")),
    ("copper", include_str!("../common/tables/copper.csv")),
    ("diabetes", include_str!("../common/tables/diabetes.csv")),
    ("engel", include_str!("../common/tables/engel.csv")),
    ("iris", include_str!("../common/tables/iris.csv")),
    ("mtcars", MTCARS),
    ("scotland", include_str!("../common/tables/scotland.csv")),
    ("stackloss", include_str!("../common/tables/stackloss.csv")),
];

/// What `scripts/differential-statistics --expected` computed: set, term, and three numbers.
const EXPECTED: &str = include_str!("../common/tables/expected.csv");

/// Returns the names of the columns of a table, and its numbers.
fn read(text: &str) -> (Vec<&str>, Mat<f64>) {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect();
    let table = Mat::from_fn(rows.len(), header.len(), |i, j| rows[i][j]);
    (header, table)
}

/// Returns these columns of mtcars.
fn mtcars(names: &[&str]) -> Mat<f64> {
    let (header, table) = read(MTCARS);
    let columns: Vec<usize> =
        names.iter().map(|name| header.iter().position(|own| own == name).unwrap()).collect();
    Mat::from_fn(table.nrows(), names.len(), |i, j| table[(i, columns[j])])
}

fn with_intercept() -> LeastSquaresOptions {
    LeastSquaresOptions::new().intercept(true)
}

#[track_caller]
fn near(found: f64, right: f64) {
    assert!((found - right).abs() <= 2e-12 * right.abs(), "{found:e} and not {right:e}");
}

#[track_caller]
fn all_near(found: impl IntoIterator<Item = f64>, right: &[f64]) {
    let found: Vec<f64> = found.into_iter().collect();
    assert_eq!(found.len(), right.len());
    found.into_iter().zip(right).for_each(|(found, &right)| near(found, right));
}

/// Returns the numbers of the first intercept and of the first column of a matrix.
fn with_first(first: &[f64], rest: &Mat<f64>) -> Vec<f64> {
    first.iter().take(1).copied().chain(rest.col(0).iter().copied()).collect()
}

fn rows(m: &Mat<f64>) -> Vec<f64> {
    m.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()).collect()
}

#[test]
fn eight_public_tables_have_the_statistics_of_multiprecision_and_statsmodels() {
    for (set, text) in TABLES {
        let (header, table) = read(text);
        // The target comes last.
        let order: Vec<usize> = (1..header.len()).chain([0]).collect();
        let table = Mat::from_fn(table.nrows(), header.len(), |i, j| table[(i, order[j])]);
        let mut names = vec!["intercept".to_owned()];
        let mut columns = Vec::new();
        for (j, &from) in order.iter().enumerate() {
            let name = header[from];
            if !["species", "cyl"].contains(&name) {
                names.push(name.to_owned());
                columns.push(DesignColumn::Numbers(j));
                continue;
            }
            let factor = Factor::of_numbers(name, table.col(j).iter().copied().collect()).unwrap();
            names.extend(factor.columns());
            columns.push(DesignColumn::Indicators(j, factor));
        }
        let found = of_table(table.as_ref(), &Design::new(columns));
        let values = with_first(&found.intercepts, &found.coefficients);
        let errors = with_first(&found.intercept_errors, &found.standard_errors);
        let p = with_first(&found.intercept_p_values(), &found.p_values().unwrap());
        let expected =
            EXPECTED.lines().filter_map(|line| line.strip_prefix(set)?.strip_prefix(','));
        let mut terms = 0;
        for line in expected {
            let fields: Vec<&str> = line.split(',').collect();
            let right: Vec<f64> = fields[1..].iter().map(|field| field.parse().unwrap()).collect();
            if fields[0] == "F" {
                let summary = [found.r_squared[0], found.f_statistics[0], found.f_p_values()[0]];
                all_near(summary, &right);
                continue;
            }
            assert_eq!(fields[0], names[terms], "{set}");
            all_near([values[terms], errors[terms], p[terms]], &right);
            terms += 1;
        }
        assert_eq!(terms, values.len(), "{set}");
    }
}

#[test]
fn the_regression_of_mtcars_is_that_of_r() {
    // lm(mpg ~ wt + hp)
    let (a, b) = (mtcars(&["wt", "hp"]), mtcars(&["mpg"]));
    let found = lstsq(a.as_ref(), b.as_ref(), None, &with_intercept()).unwrap();
    let coefficients = [37.227_270_116_447_2, -3.877_830_742_404_680_7, -0.031_772_946_982_161];
    all_near(with_first(&found.intercepts, &found.coefficients), &coefficients);
    let errors = [1.598_787_537_999_393, 0.632_733_494_377_394_6, 0.009_029_709_675_855_715];
    all_near(with_first(&found.intercept_errors, &found.standard_errors), &errors);
    let t = [23.284_688_697_930_88, -6.128_695_219_810_418, -3.518_711_910_208_783];
    all_near(with_first(&found.intercept_t_statistics(), &found.t_statistics().unwrap()), &t);
    let p = [2.565_458_511_983_685_8e-20, 1.119_647_136_200_024_6e-6, 0.001_451_228_531_569_414_7];
    all_near(with_first(&found.intercept_p_values(), &found.p_values().unwrap()), &p);
    let [lower, upper] = found.confidence_intervals(0.95).unwrap();
    let [[low, high]] = found.intercept_intervals(0.95).unwrap()[..] else { panic!("one") };
    let ends = [33.957_382_452_258_47, -5.171_916_040_675_534_5, -0.050_240_776_871_073_596];
    all_near(with_first(&[low], &lower), &ends);
    let ends = [40.497_157_780_635_92, -2.583_745_444_133_826_6, -0.013_305_117_093_248_4];
    all_near(with_first(&[high], &upper), &ends);
    near(found.residual_deviations()[0], 2.593_411_777_226_565);
    near(found.r_squared[0], 0.826_785_451_882_791_4);
    near(found.adjusted_r_squared()[0], 0.814_839_620_978_156_3);
    near(found.f_statistics[0], 69.211_213_391_777_75);
    near(found.f_p_values()[0], 9.109_054_385_221_927e-12);
    assert_eq!((found.observations, found.degrees_of_freedom), (32, 29));
    let covariance = [
        [2.556_121_591_662_160_2, -0.735_945_146_418_474_1, 0.000_148_470_052_650_844_15],
        [-0.735_945_146_418_474_1, 0.400_351_674_907_028_44, -0.003_763_690_019_096_128],
        [0.000_148_470_052_650_844_15, -0.003_763_690_019_096_128, 8.153_565_683_024_233e-5],
    ];
    all_near(rows(&found.covariance(0).unwrap()), covariance.as_flattened());
    // predict(fit, data.frame(wt = 3, hp = 150), se.fit = TRUE)
    let (model, new) = (found.model(), mat![[3.0, 150.0]]);
    near(model.predict(new.as_ref()).unwrap()[(0, 0)], 20.827_835_841_909_007);
    near(model.standard_errors(new.as_ref()).unwrap()[(0, 0)], 0.485_168_078_714_751_1);
    for (interval, error) in [
        (Interval::Confidence, 0.485_168_078_714_751_1),
        (Interval::Prediction, 2.638_403_439_745_562),
    ] {
        let [lower, upper] = model.intervals(new.as_ref(), interval, 0.95).unwrap();
        let width = 2.045_229_642_132_704 * error;
        near(lower[(0, 0)], 20.827_835_841_909_007 - width);
        near(upper[(0, 0)], 20.827_835_841_909_007 + width);
    }
}

#[test]
fn a_regression_without_intercept_is_about_zero() {
    // lm(mpg ~ wt + hp - 1)
    let (a, b) = (mtcars(&["wt", "hp"]), mtcars(&["mpg"]));
    let found = lstsq(a.as_ref(), b.as_ref(), None, &LeastSquaresOptions::new()).unwrap();
    all_near(
        rows(&found.p_values().unwrap()),
        &[0.001_097_838_592_587_257_1, 0.395_882_072_615_036_16],
    );
    near(found.adjusted_r_squared()[0], 0.708_187_676_368_365_5);
    near(found.f_statistics[0], 39.829_761_131_669_656);
    near(found.f_p_values()[0], 3.598_517_158_802_646_4e-9);
    let covariance = [3.588_174_114_799_655, -0.070_843_873_920_211_88, -0.070_843_873_920_211_88];
    all_near(rows(&found.covariance(0).unwrap()).into_iter().take(3), &covariance);
    assert!(found.intercept_p_values().is_empty());
}

#[test]
fn longley_has_the_statistics_of_statsmodels_and_r() {
    let sets = NistSet::all().unwrap();
    let set = sets.iter().find(|set| set.name == "longley").unwrap();
    let a = set.design.as_ref().subcols(1, 6);
    let found = lstsq(a, column(&set.response), None, &with_intercept()).unwrap();
    let p = [
        0.003_560_403_663_726_231,
        0.863_140_832_809_214_3,
        0.312_681_061_092_711,
        0.002_535_091_734_111_276,
        0.000_944_366_764_161_793_3,
        0.826_211_795_763_646_9,
        0.003_036_803_341_630_289_4,
    ];
    all_near(with_first(&found.intercept_p_values(), &found.p_values().unwrap()), &p);
    near(found.f_statistics[0], 330.285_339_234_588_3);
    near(found.f_p_values()[0], 4.984_030_528_724_789e-10);
    near(found.adjusted_r_squared()[0], 0.992_465_007_628_826_1);
    near(found.residual_deviations()[0], 304.854_073_561_964_8);
    let first = [
        792_848_459_543.500_6,
        -15_495_015.833_200_285,
        24_337.496_555_419_635,
        363_554.798_592_518_96,
        104_883.692_334_017_54,
        -82_671.305_069_944_18,
        -405_441_421.493_740_9,
    ];
    all_near(found.covariance(0).unwrap().row(0).iter().copied(), &first);
    let last = a.subrows(15, 1);
    near(found.model().predict(last).unwrap()[(0, 0)], 70_757.757_825_193_74);
    near(found.model().standard_errors(last).unwrap()[(0, 0)], 252.976_463_074_992_27);
}

/// Solves for the last column of a table, of which columns may be factors.
fn of_table(table: MatRef<'_, f64>, design: &Design) -> LeastSquares {
    let mut table = DenseRows(table);
    let mut rows = design.rows(&mut table).unwrap();
    let row_options = RowOptions::<f64>::new().center(Center::Mean);
    let gram = ata_extended(&mut rows, &row_options, &AtaOptions::new()).unwrap();
    LeastSquares::from_gram(&gram, 1, &with_intercept()).unwrap()
}

/// Returns the design of columns wt, cyl (a factor) and mpg.
fn with_cylinders(table: MatRef<'_, f64>) -> Design {
    let survey = Survey::of(&mut DenseRows(table), &[0, 1, 2], &[1], Par::Seq).unwrap();
    let factor = Factor::of_numbers("cyl", survey.entries[0].clone()).unwrap();
    assert_eq!(factor.columns(), ["cyl[6]", "cyl[8]"]);
    let columns = vec![
        DesignColumn::Numbers(0),
        DesignColumn::Indicators(1, factor),
        DesignColumn::Numbers(2),
    ];
    Design::new(columns).without_rows(survey.missing)
}

#[test]
fn a_factor_has_the_coefficients_of_r() {
    // lm(mpg ~ wt + factor(cyl))
    let table = mtcars(&["wt", "cyl", "mpg"]);
    let found = of_table(table.as_ref(), &with_cylinders(table.as_ref()));
    let coefficients = [
        33.990_794_009_132_47,
        -3.205_613_256_192_864_7,
        -4.255_582_401_971_285,
        -6.070_859_680_490_879,
    ];
    all_near(with_first(&found.intercepts, &found.coefficients), &coefficients);
    let p = [
        6.257_245_566_074_225e-17,
        0.000_213_043_460_268_460_04,
        0.004_717_833_899_868_905,
        0.000_999_189_323_675_411_7,
    ];
    all_near(with_first(&found.intercept_p_values(), &found.p_values().unwrap()), &p);
    near(found.f_statistics[0], 48.078_724_954_342_42);
    near(found.f_p_values()[0], 3.594_288_520_462_294_3e-11);
    near(found.adjusted_r_squared()[0], 0.820_014_581_578_735_7);
    near(found.covariance(0).unwrap()[(2, 3)], 1.404_041_260_728_26);
}

#[test]
fn incomplete_rows_change_nothing_when_they_are_left_out() {
    let table = mtcars(&["wt", "cyl", "mpg"]);
    let right = of_table(table.as_ref(), &with_cylinders(table.as_ref()));
    // A row without each of its entries after every fifth row, with a level of its own.
    let incomplete = Mat::from_fn(32 + 6, 3, |i, j| match i % 6 {
        5 if j == i / 6 % 3 => f64::NAN,
        5 => [1e3, 7.0, 1e3][j],
        _ => table[(i - i / 6, j)],
    });
    let design = with_cylinders(incomplete.as_ref());
    assert_eq!(design.left_out(), [5, 11, 17, 23, 29, 35]);
    let found = of_table(incomplete.as_ref(), &design);
    assert_eq!(found.coefficients, right.coefficients);
    assert_eq!(found.p_values().unwrap(), right.p_values().unwrap());
    assert_eq!(found.covariance(0).unwrap(), right.covariance(0).unwrap());
    assert_eq!(found.observations, 32);
}

#[test]
fn rows_of_weight_0_are_no_observations() {
    // lm(mpg ~ wt + hp, weights = (0:31) %% 4)
    let (a, b) = (mtcars(&["wt", "hp"]), mtcars(&["mpg"]));
    let weights: Vec<f64> = (0..32).map(|i| f64::from(i % 4)).collect();
    let found = lstsq(a.as_ref(), b.as_ref(), Some(&weights), &with_intercept()).unwrap();
    assert_eq!((found.observations, found.degrees_of_freedom), (24, 21));
    let p = [2.951_088_938_627_188e-17, 3.007_046_392_730_444_4e-7, 0.002_661_870_566_678_079];
    all_near(with_first(&found.intercept_p_values(), &found.p_values().unwrap()), &p);
    near(found.residual_deviations()[0], 3.430_357_069_009_419);
    near(found.adjusted_r_squared()[0], 0.883_518_288_949_792_3);
    near(found.f_statistics[0], 88.227_945_325_623_72);
    near(found.f_p_values()[0], 6.037_631_500_374_27e-11);
    near(found.covariance(0).unwrap()[(0, 2)], -0.000_155_333_486_210_563_3);
}

#[test]
fn statistics_are_the_same_after_merges_removals_and_files() {
    let mut rng = Rng::new(5);
    let all = Mat::<f64>::from_fn(60, 4, |_, _| rng.normal());
    let weights: Vec<f64> = (0..60).map(|i| f64::from(i % 3)).collect();
    let (rows, options) = (&mut DenseRows(all.as_ref()), AtaOptions::new());
    let bounds = RowBounds::of(rows, Some(&weights), 64, &options).unwrap();
    let sum_of = |parts: &[[usize; 2]]| {
        let mut sum = Accumulator::<f64>::extended(&bounds, true).unwrap();
        for &[first, end] in parts {
            let rows = &mut DenseRows(all.subrows(first, end - first));
            sum.add_rows(rows, Some(&weights[first..end]), &options).unwrap();
        }
        sum
    };
    let solved = |sum: Accumulator<f64>| {
        let gram = sum.finish_extended(Par::Seq).unwrap();
        let found = LeastSquares::from_gram(&gram, 1, &with_intercept()).unwrap();
        let covariance = found.covariance(0).unwrap();
        (found.observations, found.f_statistics.clone(), found.p_values().unwrap(), covariance)
    };
    let right = solved(sum_of(&[[0, 40]]));
    assert_eq!(right.0, 26);
    let mut merged = sum_of(&[[30, 40], [0, 7]]);
    let mut bytes = Vec::new();
    sum_of(&[[7, 30]]).write(&mut bytes).unwrap();
    merged.merge(Accumulator::read(&mut &bytes[..]).unwrap()).unwrap();
    assert_eq!(solved(merged), right);
    let mut more = sum_of(&[[0, 60]]);
    let rows = &mut DenseRows(all.subrows(40, 20));
    more.remove_rows(rows, Some(&weights[40..]), &options).unwrap();
    assert_eq!(solved(more), right);
    let mut without = sum_of(&[[1, 2]]);
    let block = mat![[0.0, 0.0, 0.0, 0.0]];
    let refused = without.remove_block(block.as_ref(), Some(&[0.0]), &options).unwrap_err();
    assert!(refused.to_string().contains("1 rows of weight 0"), "{refused}");
}

#[test]
fn what_has_no_statistics_says_so() {
    let (a, b) = (mtcars(&["wt"]), mtcars(&["mpg"]));
    let options = with_intercept().standard_errors(false);
    let found = lstsq(a.as_ref(), b.as_ref(), None, &options).unwrap();
    let refused = found.p_values().unwrap_err();
    assert_eq!(refused.to_string(), "standard_errors: were not requested");
    assert_eq!(found.covariance(0).unwrap_err(), refused);
    let refused = found.model().standard_errors(a.as_ref()).unwrap_err();
    assert!(refused.to_string().starts_with("uncertainty: the model has none"), "{refused}");
    assert!(found.model().predict(a.as_ref()).is_ok());
    let found = lstsq(a.as_ref(), b.as_ref(), None, &with_intercept()).unwrap();
    for confidence in [0.0, 1.0, 95.0, f64::NAN] {
        let refused = found.confidence_intervals(confidence).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "confidence", .. }), "{refused}");
    }
    assert!(matches!(found.covariance(1), Err(Error::Argument { what: "target", .. })));
    let two = mtcars(&["wt", "hp"]);
    assert!(matches!(found.model().predict(two.as_ref()), Err(Error::Shape { what: "rows", .. })));
    // Two rows, two coefficients: no degrees of freedom.
    let (a, b) = (a.subrows(0, 2), b.subrows(0, 2));
    let found = lstsq(a, b, None, &with_intercept()).unwrap();
    assert!(found.p_values().unwrap()[(0, 0)].is_nan());
    assert!(found.f_p_values()[0].is_nan() && found.adjusted_r_squared()[0].is_nan());
    // An exact fit, and a ridge.
    let (a, b) = (mat![[0.0], [1.0], [2.0]], mat![[1.0], [3.0], [5.0]]);
    let found = lstsq(a.as_ref(), b.as_ref(), None, &with_intercept()).unwrap();
    assert_eq!((found.f_statistics[0], found.f_p_values()[0]), (f64::INFINITY, 0.0));
    assert_eq!(found.p_values().unwrap()[(0, 0)], 0.0);
    let found = lstsq(a.as_ref(), b.as_ref(), None, &with_intercept().ridge(1.0)).unwrap();
    assert!(found.f_statistics[0].is_nan() && found.p_values().unwrap()[(0, 0)] > 0.0);
}
