from kabo.viewer.content.arrays import Arrays as Arrays
from kabo.viewer.content.document import ViewDocument as ViewDocument
from kabo.viewer.content.given import ViewOptions as ViewOptions
from kabo.viewer.content.given import document_of_file as document_of_file
from kabo.viewer.content.scene_view import scene_view as scene_view
from kabo.viewer.page.writing import page_of as page_of
