"""Finds case files without importing them, and the trees that they belong to."""

from .case_files import (
    case_files as case_files,
    examined as examined,
    imported_files as imported_files,
    is_case_file as is_case_file,
    shipped_cases as shipped_cases,
)
from .own_files import is_own as is_own
from .trees import (
    TREE_FILE as TREE_FILE,
    chapter_title as chapter_title,
    data_folder as data_folder,
    files_below as files_below,
    place as place,
    tree_of as tree_of,
)
