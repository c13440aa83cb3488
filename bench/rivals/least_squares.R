# Fits tables by lm. Each of standard input's lines has, between tabs, a table, a formula, the
# factors as NAME=BASE between semicolons, and the file to write: a line for each kind of number,
# whose name comes first.

write <- function(fit, path) {
    found <- summary(fit)
    f <- found$fstatistic
    kinds <- list(
        values = coef(found)[, 1], errors = coef(found)[, 2], t = coef(found)[, 3],
        p = c(coef(found)[, 4], pf(f[1], f[2], f[3], lower.tail = FALSE)),
        ends = t(confint(fit)), covariance = vcov(fit),
        summary = c(found$r.squared, found$adj.r.squared, f[1], found$sigma)
    )
    line <- function(kind) paste(c(kind, sprintf("%.17g", kinds[[kind]])), collapse = ",")
    names <- paste(c("names", names(coef(fit))), collapse = ",")
    writeLines(c(names, sapply(names(kinds), line)), path)
}

for (line in readLines("stdin")) {
    fields <- strsplit(line, "\t")[[1]]
    table <- read.csv(fields[1])
    for (factor in strsplit(fields[3], ";")[[1]]) {
        pair <- strsplit(factor, "=")[[1]]
        table[[pair[1]]] <- relevel(factor(table[[pair[1]]]), pair[2])
    }
    write(lm(as.formula(fields[2]), table), fields[4])
}
