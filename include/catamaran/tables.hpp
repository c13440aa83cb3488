// Tables: the matrices in files, and what is known about their columns.

#ifndef CATAMARAN_TABLES_HPP
#define CATAMARAN_TABLES_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

/// Whether a file has something.
enum class presence : std::int32_t { automatic = CATA_AUTO, yes = CATA_YES, no = CATA_NO };

/// What becomes of a row with a missing cell in a column that is used.
enum class missing_cells : std::int32_t {
    error = CATA_MISSING_ERROR,
    drop = CATA_MISSING_DROP,
    nan = CATA_MISSING_NAN,
};

/// How a table is read: the fields of cata_table_params. What is 0 or empty, the file decides.
struct table_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
    /// Bytes of memory that the table may take.
    std::uint64_t max_memory = 0;
    /// Lines at the start of the file that are left out.
    std::size_t skip = 0;
    /// Names, numbers or ranges of columns, between commas; empty for all but those of words.
    std::string columns;
    /// Columns that become factors if one of their entries is a word, between commas.
    std::string factors;
    /// The words of missing cells, between commas; empty for those of pandas.
    std::string missing_words;
    /// The encoding of the text.
    std::string encoding;
    /// As cata_table_params.format.
    std::string format;
    /// What becomes of rows with missing cells.
    missing_cells missing = missing_cells::error;
    /// Whether the first row has the names of the columns.
    presence header = presence::automatic;
    /// Whether the first column numbers or names the rows, and is left out.
    presence index = presence::automatic;
    /// The character between fields; a blank for runs of blanks and tabs.
    char separator = 0;
    /// '.' or ','.
    char decimal = 0;
    /// The separator of groups of three digits.
    char thousands = 0;
    /// The character that starts a comment.
    char comment = 0;
};

namespace detail {

/// cata_table_params for the length of a call.
class table_call {
public:
    explicit table_call(const table_options& how) : watcher_(how.progress) {
        const auto given = [](const std::string& text) {
            return text.empty() ? nullptr : text.c_str();
        };
        check(cata_table_params_init(&params_, sizeof params_));
        params_.threads = how.threads;
        params_.max_memory = how.max_memory;
        params_.skip = how.skip;
        params_.columns = given(how.columns);
        params_.factors = given(how.factors);
        params_.missing_words = given(how.missing_words);
        params_.encoding = given(how.encoding);
        params_.format = given(how.format);
        params_.missing = static_cast<std::int32_t>(how.missing);
        params_.header = static_cast<std::int32_t>(how.header);
        params_.index = static_cast<std::int32_t>(how.index);
        params_.separator = how.separator;
        params_.decimal = how.decimal;
        params_.thousands = how.thousands;
        params_.comment = how.comment;
        watcher_.attach(params_);
    }

    const cata_table_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_table_params params_{};
    watcher watcher_;
};

}  // namespace detail

/// A matrix that was read, and what is known about its columns: cata_table.
class table {
public:
    /// Takes a handle, which is freed with this.
    explicit table(cata_table* handle) : handle_(handle) {
        detail::check(cata_table_shape(get(), &rows_, &cols_, &dropped_rows_));
    }

    /// The table in a file: cata_table_read.
    static table read(const std::string& path, const table_options& how = {}) {
        detail::table_call call(how);
        cata_table* made = nullptr;
        call.finish(cata_table_read(path.c_str(), call.params(), &made));
        return table(made);
    }

    /// Number of rows.
    std::size_t rows() const noexcept { return rows_; }
    /// Number of columns.
    std::size_t cols() const noexcept { return cols_; }
    /// Rows that were left out because a cell is missing.
    std::uint64_t dropped_rows() const noexcept { return dropped_rows_; }

    /// rows x cols without gaps: an entry of a factor is the number of its level, a missing cell
    /// NaN.
    std::vector<double> entries(layout order = layout::row_major) const {
        std::vector<double> found(rows_ * cols_);
        detail::check(cata_table_entries(get(), static_cast<std::int32_t>(order), found.data(),
                                         detail::gapless(order, rows_, cols_)));
        return found;
    }

    /// The name of a column, in UTF-8; empty without names.
    std::string name(std::size_t column) const { return cata_table_name(get(), column); }

    /// The levels of a factor, in UTF-8; none for a column of numbers.
    std::vector<std::string> levels(std::size_t column) const {
        std::vector<std::string> found;
        for (std::size_t i = 0; i < cata_table_levels(get(), column); ++i) {
            found.emplace_back(cata_table_level(get(), column, i));
        }
        return found;
    }

    /// What was decided about a text table, and which integers were rounded, in UTF-8; else empty.
    std::string reading() const { return cata_table_reading(get()); }

    /// The handle, owned by this.
    const cata_table* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_table* handle) const noexcept { cata_table_free(handle); }
    };

    std::unique_ptr<cata_table, free> handle_;
    std::size_t rows_ = 0;
    std::size_t cols_ = 0;
    std::uint64_t dropped_rows_ = 0;
};

}  // namespace catamaran

#endif
