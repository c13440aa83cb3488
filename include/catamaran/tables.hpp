// Tables in files.

#ifndef CATAMARAN_TABLES_HPP
#define CATAMARAN_TABLES_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

/// What happens to a row with a missing cell in a column that is used.
enum class missing_cells : std::int32_t {
    refuse = CATA_MISSING_ERROR,
    drop_row = CATA_MISSING_DROP,
    nan = CATA_MISSING_NAN,
};

/// Whether a table has a header or an index.
enum class presence : std::int32_t { by_content = CATA_AUTO, yes = CATA_YES, no = CATA_NO };

/// How a table is read: the fields of cata_table_params. What is empty or 0, the file decides.
struct table_options {
    /// 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Bytes of memory that the table may take; 0: a limit that suits usual files.
    std::uint64_t max_memory = 0;
    /// Lines at the start of the file that are left out.
    std::size_t skip = 0;
    /// Columns that are used: names, numbers from 0, ranges `3..5`, or a list of these between
    /// commas; empty: all but those of words.
    std::string columns;
    /// Columns that become factors if one of their entries is a word, between commas.
    std::string factors;
    /// The words of missing cells, between commas; empty: those of pandas, such as NA.
    std::string missing_words;
    /// The encoding of the text, such as "latin1".
    std::string encoding;
    /// "npy", "mtx" or "table".
    std::string format;
    /// What happens to rows with missing cells.
    missing_cells missing = missing_cells::refuse;
    /// Whether the first row has the names of the columns.
    presence header = presence::by_content;
    /// Whether the first column numbers or names the rows, and is left out.
    presence index = presence::by_content;
    /// The character between fields; a blank: runs of blanks and tabs.
    char separator = 0;
    /// '.' or ','.
    char decimal = 0;
    /// The separator of groups of three digits.
    char thousands = 0;
    /// The character that starts a comment; 0: '#'.
    char comment = 0;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// A matrix that was read, and what is known about its columns: cata_table.
class table {
public:
    /// Reads the matrix in a file, whose path is in UTF-8.
    explicit table(const std::string& path, const table_options& how = {}) {
        cata_table_params params;
        detail::check(cata_table_params_init(&params, sizeof params));
        params.threads = how.threads;
        params.max_memory = how.max_memory;
        params.skip = how.skip;
        params.columns = text_or_null(how.columns);
        params.factors = text_or_null(how.factors);
        params.missing_words = text_or_null(how.missing_words);
        params.encoding = text_or_null(how.encoding);
        params.format = text_or_null(how.format);
        params.missing = static_cast<std::int32_t>(how.missing);
        params.header = static_cast<std::int32_t>(how.header);
        params.index = static_cast<std::int32_t>(how.index);
        params.separator = how.separator;
        params.decimal = how.decimal;
        params.thousands = how.thousands;
        params.comment = how.comment;
        detail::watcher watcher(how.progress);
        watcher.attach(params);
        cata_table* made = nullptr;
        watcher.finish(cata_table_read(path.c_str(), &params, &made));
        handle_.reset(made);
        detail::check(cata_table_shape(made, &rows_, &columns_, &dropped_));
    }

    /// The number of rows.
    std::size_t rows() const noexcept { return rows_; }

    /// The number of columns.
    std::size_t columns() const noexcept { return columns_; }

    /// The number of rows that were left out because a cell is missing.
    std::uint64_t dropped_rows() const noexcept { return dropped_; }

    /// The entries, row by row without gaps. An entry of a factor is the number of its level, from
    /// 0; a missing cell is NaN.
    std::vector<double> entries() const {
        std::vector<double> found(rows_ * columns_);
        detail::check(cata_table_entries(handle_.get(), CATA_ROW_MAJOR, found.data(),
                                         detail::gapless(layout::row_major, rows_, columns_)));
        return found;
    }

    /// The name of a column, in UTF-8; empty without names, and for a column that does not exist.
    std::string name(std::size_t column) const { return cata_table_name(handle_.get(), column); }

    /// The levels of a factor, in UTF-8; none for a column of numbers.
    std::vector<std::string> levels(std::size_t column) const {
        std::vector<std::string> found(cata_table_levels(handle_.get(), column));
        for (std::size_t i = 0; i < found.size(); ++i) {
            found[i] = cata_table_level(handle_.get(), column, i);
        }
        return found;
    }

    /// What was decided about a text table, such as "separator ;, decimal comma, header".
    std::string reading() const { return cata_table_reading(handle_.get()); }

private:
    struct free {
        void operator()(cata_table* handle) const noexcept { cata_table_free(handle); }
    };

    static const char* text_or_null(const std::string& text) noexcept {
        return text.empty() ? nullptr : text.c_str();
    }

    std::unique_ptr<cata_table, free> handle_;
    std::size_t rows_ = 0, columns_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace catamaran

#endif
